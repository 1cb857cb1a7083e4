#include "cli/campaign/table.hpp"

#include <catch2/catch.hpp>

#include "cli/exit_status.hpp"

namespace {

using namespace c3rt::cli;
using namespace c3rt::cli::campaign;
using Catch::Contains;

/// A run with two criteria (band at least 0.98, largest error at most 0.02) and one more figure.
RunResult result(std::uint64_t seed, double band, double error) {
  RunResult run;
  run.spec = {"seed", "circle_slow", seed, {"planner.rate_hz=50"}};
  const bool band_met = band >= 0.98, error_met = error <= 0.02;
  run.status = band_met && error_met ? kDone : kCriterionFailed;
  run.report = {
      {"result", run.status == kDone ? "passed" : "criteria not met"},
      {"criteria",
       {{{"name", "in_band_2cm"}, {"value", band}, {"limit", 0.98}, {"met", band_met}},
        {{"name", "path_error_max_m"}, {"value", error}, {"limit", 0.02}, {"met", error_met}}}},
      {"objects", {{{"max_error_m", error}}}}};
  return run;
}

RunResult crashed(std::uint64_t seed) {
  RunResult run;
  run.spec = {"seed", "circle_slow", seed};
  run.status = kProcessFailed;
  run.failure = "planner was killed by signal 11";
  return run;
}

}  // namespace

TEST_CASE("the summary counts a failed process as no success, and keeps it out of the figures") {
  const Summary summary = summarise({result(1, 1.0, 0.01), result(2, 0.9, 0.03), crashed(3)});
  CHECK(summary.passed == 1);
  CHECK(summary.missed == 1);
  CHECK(summary.failed == 1);
  CHECK(summary.success.count == 3);
  REQUIRE(summary.criteria.size() == 2);
  CHECK(summary.criteria[0].met.successes == 1);
  CHECK(summary.criteria[0].met.count == 2);
  CHECK(summary.criteria[0].values->worst == 0.9);  // more is better
  CHECK(summary.criteria[0].worst_seed == 2);
  CHECK(summary.criteria[1].values->worst == 0.03);
  REQUIRE(summary.figures.size() == 1);
  CHECK(summary.figures[0].name == "objects.0.max_error_m");
  CHECK(summary.figures[0].values.count == 2);
}

TEST_CASE("worth a look is what failed; then what missed most; then the first criterion's worst") {
  const RunResult good = result(1, 1.0, 0.010), better = result(2, 1.0, 0.005);
  const RunResult one = result(3, 0.95, 0.01), both = result(4, 0.97, 0.05);
  CHECK(summarise({good, better}).worst == 0);
  CHECK(summarise({better, good}).worst == 1);
  CHECK(summarise({good, one, both}).worst == 2);
  CHECK(summarise({one, result(5, 0.90, 0.01)}).worst == 1);
  CHECK(summarise({both, crashed(6), one}).worst == 1);
}

TEST_CASE("criteria come first in the table, and the verdict has the interval") {
  const Summary summary = summarise({result(1, 1.0, 0.01), result(2, 1.0, 0.02)});
  const Rows table = rows(summary);
  REQUIRE(table.size() == 4);
  CHECK(table[1].front() == "criterion in_band_2cm (limit 0.98)");
  CHECK(table[1][1] == "2 of 2");
  CHECK(table[3].front() == "objects.0.max_error_m");
  CHECK(table[3][4] == "0.015");  // the median
  CHECK(verdict(summary) == "2 of 2 passed (100 %, 95 % confidence: 34 to 100 %)");
}

TEST_CASE("the JSON tells every run, and how to see the worst one again") {
  const std::vector<RunResult> results{result(7, 0.5, 0.01), crashed(8)};
  const ordered_json json = to_json(summarise(results), results);
  CHECK(json.at("worst").at("seed") == 8);
  CHECK(json.at("worst").at("command") == "c3rt run circle_slow --clock lockstep --seed 8");
  CHECK(json.at("runs").at(0).at("criteria_missed") == ordered_json({"in_band_2cm"}));
  CHECK_THAT(json.at("runs").at(1).at("result").get<std::string>(), Contains("signal 11"));
  CHECK(json.at("figures").at("objects.0.max_error_m").at("worst_seed") == 7);
}

TEST_CASE("the command of a run again quotes what a shell would take apart") {
  RunSpec spec{"x", "circle_slow", 3, {"planner.rate_hz=50", "task.center_m=[0.5, 0]"}, 12.5};
  CHECK(replay_command(spec) ==
        "c3rt run circle_slow --clock lockstep --seed 3 --duration 12.5 --set planner.rate_hz=50 "
        "--set 'task.center_m=[0.5, 0]'");
  spec = {"x", "cart_pole", 4};
  spec.example = true;
  CHECK(replay_command(spec) == "c3rt run cart_pole --seed 4");
}
