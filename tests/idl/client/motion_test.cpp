#include "idl/client/motion.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "idl/validate.hpp"

using namespace c3rt;
using namespace c3rt::client;

namespace {

constexpr std::int64_t kMs = 1'000'000;

wire::RobotState state_at(std::int64_t time_ns, double x) {
  wire::RobotState state{};
  state.header = {1, static_cast<std::uint64_t>(time_ns), time_ns};
  state.p_WE_m[0] = x;
  state.q_rad[6] = 0.7;
  state.mode = c3rt_v2_ROBOT_MOVE;
  return state;
}

Motion along_x(int knots) {
  Motion motion;
  for (int i = 0; i < knots; ++i) motion.knots.push_back({{0.5 + 0.01 * i, 0, 0.1}, {}, 0.05 * i});
  return motion;
}

}  // namespace

TEST_CASE("motion: the end effector's velocity is that of the last milliseconds alone") {
  Observations observed;
  CHECK_FALSE(observed.has_state());
  for (int i = 1; i <= 20; ++i)  // 0.1 m/s, then 0.3 m/s
    observed.add(state_at(i * kMs, i < 10 ? 1e-4 * i : 9e-4 + 3e-4 * (i - 9)));
  const Situation now = observed.situation(21 * kMs);
  CHECK(now.time == Approx(0.021));
  CHECK(now.effector.v[0] == Approx(0.3));
  CHECK(now.effector.q[6] == 0.7);
  CHECK(now.effector.moves);
  CHECK(now.objects.empty());
  // a plant that was started again begins at 0: no velocity reaches from one life to the other
  observed.add(state_at(kMs, 0.5));
  CHECK(observed.situation(kMs).effector.v[0] == 0.0);
}

TEST_CASE("motion: objects are known by their index, with the age of what was seen") {
  Observations observed;
  observed.add(state_at(10 * kMs, 0.0));
  wire::ObjectEstimate estimate{};
  estimate.object_index = 3;
  estimate.valid = true;
  estimate.exposure_ns = 4 * kMs;
  estimate.header.time_ns = 9 * kMs;
  estimate.v_WB_m_per_s[1] = -0.2;
  observed.add(estimate);
  const Situation now = observed.situation(11 * kMs);
  REQUIRE(now.objects.size() == 1);
  CHECK(now.objects.at(3).age == Approx(0.007));
  CHECK(now.objects.at(3).v[1] == -0.2);
  CHECK(observed.origin().state_ns == 10 * kMs);
  CHECK(observed.origin().exposure_ns == 4 * kMs);
  CHECK(observed.origin().estimate_ns == 9 * kMs);
}

TEST_CASE("motion: a plan of 16 knots is one that every reader lets in") {
  Motion motion = along_x(16);
  motion.knots[2].q = {0, 3, 4, 0};
  const wire::Plan plan = plan_sample(motion, 100 * kMs, 0.5);
  CHECK_FALSE(wire::validate(plan));
  CHECK(plan.knot_count == 16);
  CHECK(plan.knots[15].time_ns == 850 * kMs);
  CHECK(plan.knots[15].p_WE_m[0] == Approx(0.65));
  CHECK(plan.knots[2].q_WE[1] == Approx(0.6));
  CHECK(plan.valid_until_ns == 600 * kMs);
  CHECK(std::string(plan.phase) == "task");
}

TEST_CASE("motion: what no reader would let in is named before it is sent") {
  const auto refused = [](const Motion& motion) -> std::string {
    try {
      plan_sample(motion, 100 * kMs, 0.5);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refused({}) == "knots: expected 1 to 16, got 0");
  CHECK(refused(along_x(17)) == "knots: expected 1 to 16, got 17");
  Motion motion = along_x(2);
  motion.knots[1].after = -0.1;
  CHECK(refused(motion) == "knots[1].after: expected 0 to 10 s, got -0.1");
  motion.knots[1].after = 0.0;
  CHECK_THAT(refused(motion), Catch::Contains("after the knot before"));
  motion = along_x(2);
  motion.knots[0].v[2] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(refused(motion), Catch::Contains("v_WE_m_per_s"));
  motion = along_x(2);
  motion.knots[1].q = {0, 0, 0, 0};
  CHECK_THAT(refused(motion), Catch::Contains("zero quaternion knots.q_WE[1]"));
  motion = along_x(2);
  motion.phase = std::string(32, 'a');
  CHECK_THAT(refused(motion), Catch::StartsWith("phase: expected a text of 1 to 31 bytes"));
}
