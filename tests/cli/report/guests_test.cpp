// What a client did that played a process, from streams whose faults are known.
#include "cli/report/guests.hpp"

#include <stdexcept>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace c3rt::cli;
using Catch::Contains;

namespace {

constexpr std::int64_t kMs = 1'000'000;
const GuestLimits kLimits{0.2, "impedance.limits.plan_timeout_s"};

/// Plans every 10 ms from 1 s on, each in effect 8 ms after its state.
Series good_plans(int count = 300) {
  Series series;
  SceneRow scene{};
  scene.time_ns = 1000 * kMs;
  series.scene.push_back(scene);
  for (int i = 0; i < count; ++i) {
    PlanRow plan{};
    plan.state_ns = (1000 + 10 * i) * kMs;
    plan.time_ns = plan.state_ns + 8 * kMs;
    series.plan.push_back(plan);
  }
  return series;
}

Guest look(const Series& series) { return look_at_guest("planner", series, kLimits, {}); }

}  // namespace

TEST_CASE("guests: a planner that does all right has its rate and age, and no problem") {
  const Guest guest = look(good_plans());
  CHECK(guest.topic == "plan");
  CHECK(guest.samples == 300);
  CHECK(guest.rate == Approx(100.0));
  CHECK(guest.age.p50 == Approx(0.008));
  CHECK(guest.age.max == Approx(0.008));
  CHECK(guest.problems.empty());
  CHECK(to_json(guest).at("problems").empty());
}

TEST_CASE(
    "guests: gaps, late plans, missing and impossible stamps are named, each with its count") {
  Series series = good_plans();
  PlanRow plan{};
  plan.time_ns = (1000 + 2990 + 8 + 350) * kMs;  // 0.35 s after the last
  series.plan.push_back(plan);                   // without a stamp
  plan.time_ns += 10 * kMs;
  plan.state_ns = plan.time_ns + kMs;
  series.plan.push_back(plan);
  const Guest gaps = look(series);
  REQUIRE(gaps.problems.size() == 3);
  CHECK(
      gaps.problems[0] ==
      "rate: 1 gap of more than 0.2 s (impedance.limits.plan_timeout_s), the longest 0.350 s from "
      "2.998 s on");
  CHECK(gaps.problems[1] == "stamps: 1 of 302 samples have no origin.state_ns");
  CHECK_THAT(gaps.problems[2], Contains("1 of 302 samples take effect before the robot state"));

  Series late = good_plans(0);
  for (int i = 0; i < 100; ++i) {
    plan.time_ns = (2000 + 10 * i) * kMs;
    plan.state_ns = plan.time_ns - 300 * kMs;
    late.plan.push_back(plan);
  }
  const Guest behind = look(late);
  REQUIRE(behind.problems.size() == 1);
  CHECK_THAT(behind.problems[0], Contains("late: in effect 0.300 s after the robot state"));
}

TEST_CASE(
    "guests: a client that has fallen silent before the end is named, one at the end is not") {
  Series series = good_plans();
  StateRow state{};
  state.time_ns = series.plan.back().time_ns + 150 * kMs;
  series.state.push_back(state);
  CHECK(look(series).problems.empty());
  state.time_ns += 3000 * kMs;
  series.state.push_back(state);
  CHECK(look(series).problems ==
        std::vector<std::string>{"silent: nothing came after 2.998 s, for the last 3.150 s"});
}

TEST_CASE(
    "guests: what was refused is told with who refused it and why, and silence is a problem") {
  const Guest guest =
      look_at_guest("planner", Series(), kLimits,
                    {{"impedance", 12, "value", "knot_count is 17, expected 1 to 16"}});
  REQUIRE(guest.problems.size() == 2);
  CHECK(guest.problems[0] == "nothing of plan was let in");
  CHECK(guest.problems[1] ==
        "refused: 12 by impedance (value): knot_count is 17, expected 1 to 16");
}

TEST_CASE("guests: each object's estimates are a stream of its own") {
  Series series;
  for (int i = 0; i < 200; ++i) {
    for (int object = 0; object < 2; ++object) {
      if (object == 1 && i >= 80 && i < 120) continue;  // lost for 0.5 s
      EstimateRow row{};
      row.exposure_ns = 1000 * kMs + i * 12'500'000LL;
      row.time_ns = row.exposure_ns + 9 * kMs;
      row.object = object;
      series.estimate.push_back(row);
    }
  }
  const Guest guest = look_at_guest("vision", series, {0.25, "planner.estimate_timeout_s"}, {});
  CHECK(guest.samples == 360);
  REQUIRE(guest.problems.size() == 1);
  CHECK_THAT(guest.problems[0], Contains("1 gap of more than 0.25 s") && Contains("of object 1"));
  CHECK_THROWS_AS(look_at_guest("plant", series, kLimits, {}), std::invalid_argument);
}
