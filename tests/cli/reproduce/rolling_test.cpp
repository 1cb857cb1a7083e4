// A figure of section VII from real runs of a few simulated seconds.
#include "cli/reproduce/rolling.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/folder.hpp"

using namespace c3rt::cli;
using namespace c3rt::cli::reproduce;

TEST_CASE("figures are found in a report by their path, and what is not there is no number") {
  const ordered_json report = ordered_json::parse(
      R"({"objects": [{"rms_error_m": 0.5}], "vision": {"rate_hz": null}, "loop_times_s": [19.04, 20.0]})");
  CHECK(figure(report, "objects.0.rms_error_m") == 0.5);
  for (const char* path :
       {"objects.1.rms_error_m", "objects.0.max", "vision.rate_hz", "nothing", "objects"})
    CHECK(std::isnan(figure(report, path)));
  CHECK(loop_times(report) == "19.0, 20.0");
  CHECK(loop_times({{"loop_times_s", ordered_json::array()}}) == "-");
}

TEST_CASE("fig11: both circles run, and the tracks of their logs agree with their reports") {
  const Folder folder;
  const std::string command = "'" C3RT_BINARY_DIRECTORY
                              "/bin/c3rt' reproduce fig11 --quick --out '" +
                              folder.path().string() + "' >/dev/null 2>&1";
  REQUIRE(std::system(command.c_str()) == 0);
  CHECK(std::filesystem::exists(folder.path() / "fig11.png"));
  const ordered_json results = ordered_json::parse(std::ifstream(folder.path() / "fig11.json"));
  CHECK(results.at("slow").at("paper").at("loop_time_s") == 30.0);
  CHECK(results.at("fast").at("report").at("scenario") == "circle_fast");

  Run run;
  run.folder = folder.path() / "runs" / "fig11-slow";
  run.report = results.at("slow").at("report");
  const ObjectTrack track = object_track(run);
  REQUIRE(track.time.size() > 100);
  CHECK(track.time.front() >= 0.0);
  CHECK(track.time.front() < 0.02);
  double largest = 0.0;  // distance to the circle of 0.1 m about (0.55, 0)
  for (const Eigen::Vector2d& p : track.position)
    largest = std::max(largest, std::abs((p - Eigen::Vector2d(0.55, 0.0)).norm() - 0.1));
  CHECK(largest == Approx(figure(run.report, "objects.0.max_error_m")).margin(2e-6));

  const EndEffectorTrack arm = end_effector_track(run);
  REQUIRE(arm.time.size() > 1000);
  // the report counts from a second after tracking began, which the approach is part of
  double error = 0.0;
  for (std::size_t i = 0; i < arm.time.size(); ++i)
    error = std::max(error, (arm.position[i] - arm.desired[i]).norm());
  CHECK(error <= figure(run.report, "end_effector.tracking_error_m.max") + 1e-8);
  CHECK(error > 1e-4);
}
