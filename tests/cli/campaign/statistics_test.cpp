#include "cli/campaign/statistics.hpp"

#include <cmath>
#include <map>

#include <catch2/catch.hpp>

using namespace c3rt::cli::campaign;

TEST_CASE(
    "Wilson's interval: its ends are the shares that are 1.96 deviations from what was seen") {
  // the defining equation: |p̂ − p| = z √(p (1 − p) / n)
  constexpr double z = 1.959963984540054;
  for (const auto& [successes, count] : {std::pair{1, 10}, {19, 20}, {18, 20}, {500, 1000}}) {
    const Proportion p = wilson(successes, count);
    const double seen = static_cast<double>(successes) / count;
    CHECK(p.share == Approx(seen));
    for (const double end : {p.low, p.high})
      CHECK(std::abs(seen - end) == Approx(z * std::sqrt(end * (1.0 - end) / count)).epsilon(1e-9));
    CHECK(p.low < seen);
    CHECK(seen < p.high);
  }
}

TEST_CASE("Wilson's interval of no and of only successes ends at 0 and 1, but is no point") {
  // closed form: 1 / (1 + z²/n)
  const double z2 = 1.959963984540054 * 1.959963984540054;
  CHECK(wilson(20, 20).high == 1.0);
  CHECK(wilson(20, 20).low == Approx(1.0 / (1.0 + z2 / 20.0)));  // 0.839
  CHECK(wilson(0, 5).low == 0.0);
  CHECK(wilson(0, 5).high == Approx(z2 / 5.0 / (1.0 + z2 / 5.0)));
  CHECK(wilson(1, 1).low == Approx(0.20654).epsilon(1e-4));  // tabulated
}

TEST_CASE("the worst of a distribution is at the end that nobody wants, and named by its index") {
  const std::vector<double> values{3.0, 1.0, 5.0, 1.0};
  const Distribution errors = distribution(values, false), shares = distribution(values, true);
  CHECK(errors.worst == 5.0);
  CHECK(errors.worst_index == 2);
  CHECK(shares.worst == 1.0);
  CHECK(shares.worst_index == 1);
  CHECK(errors.median == 2.0);
  CHECK(errors.mean == 2.5);
  CHECK(errors.count == 4);
}

TEST_CASE("the figures of a report are all of its numbers, by path") {
  const ordered_json report = ordered_json::parse(R"({
    "scenario": "circle_slow", "seed": 7, "result": "passed",
    "criteria": [{"name": "loops_completed", "value": 3, "limit": 3, "met": true}],
    "loops_completed": 3, "loop_times_s": [19.0, 21.0, 20.0], "none_s": [],
    "objects": [{"rms_error_m": 0.004, "max_error_m": null}, {"rms_error_m": 0.005}],
    "planner": {"solve_time_s": {"p50": 0.0002, "max": 0.001}},
    "plant": {"reflexes": ["cartesian_reflex"], "real_time_factor": 2.5},
    "log_hash": "fnv1a64:0"})");
  const auto list = figures(report);
  const std::map<std::string, double> by_name(list.begin(), list.end());
  const std::map<std::string, double> expected{{"loops_completed", 3.0},
                                               {"loop_times_s.median", 20.0},
                                               {"loop_times_s.worst", 21.0},
                                               {"objects.0.rms_error_m", 0.004},
                                               {"objects.1.rms_error_m", 0.005},
                                               {"planner.solve_time_s.p50", 0.0002},
                                               {"planner.solve_time_s.max", 0.001},
                                               {"plant.reflexes", 1.0},
                                               {"plant.real_time_factor", 2.5}};
  CHECK(by_name == expected);
}

TEST_CASE("of which figures more is better") {
  for (const char* name : {"objects.0.in_band_2cm", "loops_completed", "planner.rate_hz",
                           "plant.success_rate_min", "plant.real_time_factor"})
    CHECK(higher_is_better(name));
  for (const char* name :
       {"objects.0.max_error_m", "loop_times_s.worst", "planner.solve_time_s.p99",
        "vision.dropped_frames", "plant.reflexes", "duration_s"})
    CHECK_FALSE(higher_is_better(name));
}
