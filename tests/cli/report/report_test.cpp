#include "cli/report/report.hpp"

#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cli/report/pictures.hpp"
#include "controller/task/circle.hpp"
#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt::cli;
using nlohmann::ordered_json;

std::vector<std::string> keys(const ordered_json& object) {
  std::vector<std::string> names;
  for (const auto& item : object.items()) names.push_back(item.key());
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("the report has exactly the keys that other programs read") {
  Report report;
  report.figures.objects.resize(1);
  report.figures.criteria = {{"in_band_2cm", 0.97, 0.95, true}};
  const ordered_json json = to_json(report);
  REQUIRE(keys(json) ==
          Names{"scenario",        "seed",         "clock",   "duration_s", "result", "criteria",
                "loops_completed", "loop_times_s", "task",    "objects",    "judged", "path",
                "out_of_band",     "end_effector", "planner", "impedance",  "vision", "latency",
                "plant",           "clients",      "log_hash"});
  const Names quantiles{"p50", "p95", "p99", "max"};
  REQUIRE(keys(json["criteria"][0]) == Names{"name", "value", "limit", "met"});
  REQUIRE(keys(json["objects"][0]) == Names{"rms_error_m", "p95_error_m", "max_error_m",
                                            "in_band_2cm", "in_band_1cm", "arrived_after_s",
                                            "arrival_error_m", "end_error_m"});
  REQUIRE(keys(json["end_effector"]) == Names{"tracking_error_m", "approach_error_m"});
  REQUIRE(keys(json["end_effector"]["tracking_error_m"]) == quantiles);
  REQUIRE(keys(json["planner"]) == Names{"rate_hz", "solve_time_s", "overruns", "fallbacks"});
  REQUIRE(keys(json["planner"]["solve_time_s"]) == quantiles);
  REQUIRE(keys(json["impedance"]) ==
          Names{"rate_hz", "wakeup_latency_s", "compute_s", "missed_cycles", "stale_plan_events"});
  REQUIRE(keys(json["vision"]) ==
          Names{"rate_hz", "error_m", "angle_error_rad", "dropped_frames", "cameras_used_mean"});
  REQUIRE(keys(json["latency"]) ==
          Names{"state_to_command_s", "exposure_to_plan_s", "exposure_to_torque_s"});
  REQUIRE(keys(json["plant"]) == Names{"real_time_factor", "reflexes", "success_rate_min"});
}

TEST_CASE("what a run did not give is null, not a number that looks like one") {
  const ordered_json json = to_json(Report{});
  REQUIRE(json["planner"]["solve_time_s"]["p50"].is_null());
  REQUIRE(json["plant"]["real_time_factor"].is_null());
  REQUIRE(json["loop_times_s"].is_array());
  REQUIRE(ordered_json::parse(json.dump()) == json);
}

TEST_CASE("every picture is drawn, also of a run without a single sample") {
  const Folder folder;
  const c3rt::task::Circle circle{{0.55, 0.0}, 0.1, 0.35};
  REQUIRE(draw_pictures(folder.path(), Series{}, circle, Figures{}, "a \"quoted\" title") == "");
  for (const char* name :
       {"path.png", "path_error.png", "end_effector_error.png", "solve_time.png", "latency.png"}) {
    INFO(name);
    REQUIRE(std::filesystem::file_size(folder.path() / name) > 1000);
  }
}
