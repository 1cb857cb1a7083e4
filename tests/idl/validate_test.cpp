#include "idl/validate.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>

#include <catch2/catch.hpp>

#include "tests/idl/samples.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::wire;
namespace test = c3rt::wire::test;

namespace {

using support::Random;
using test::plain;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLargest = std::numeric_limits<double>::max();

// ---- what a consumer needs, written again, without the checks of idl/validate.cpp

template <typename E>
bool known(const E& value, int last) {
  std::uint32_t raw = 0;
  std::memcpy(&raw, &value, sizeof raw);
  return raw <= static_cast<std::uint32_t>(last);
}
bool known(const bool& value) {
  unsigned char raw = 0;
  std::memcpy(&raw, &value, 1);
  return raw <= 1;
}
template <std::size_t n>
bool below(const double (&values)[n], double bound) {
  for (const double value : values) {
    if (!std::isfinite(value) || std::fabs(value) > bound) return false;
  }
  return true;
}
bool unit(const double (&q)[4]) {
  return below(q, 2.0) &&
         std::fabs(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) - 1.0) <= 0.0101;
}
bool unit_or_none(const double (&q)[4]) {
  return (q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0) || unit(q);
}
template <std::size_t n>
bool ends(const char (&text)[n]) {
  for (const char letter : text) {
    if (letter == '\0') return true;
    if (static_cast<unsigned char>(letter) < ' ') return false;
  }
  return false;
}
// a difference of two stamps must be a number of seconds, not an overflow
bool near(std::int64_t stamp_ns, std::int64_t time_ns) {
  return stamp_ns >= 0 && static_cast<double>(stamp_ns) - static_cast<double>(time_ns) <= 1.001e9;
}
bool near(const Origin& origin, std::int64_t time_ns) {
  return near(origin.exposure_ns, time_ns) && near(origin.estimate_ns, time_ns) &&
         near(origin.state_ns, time_ns) && near(origin.plan_ns, time_ns);
}

bool usable(const RobotState& s) {
  return s.robot == 0 && below(s.q_rad, 10) && below(s.dq_rad_per_s, 100) && below(s.tau_nm, 1e3) &&
         below(s.p_WE_m, 5) && unit_or_none(s.q_WE) && known(s.mode, 3) &&
         s.command_success_rate >= 0 && s.command_success_rate <= 1 &&
         near(s.command_state_ns, s.header.time_ns);
}
bool usable(const RobotContact& s) {
  return s.robot == 0 && below(s.tau_external_nm, 1e6) && below(s.force_W_n, 1e6) &&
         below(s.torque_W_nm, 1e6) && below(s.force_E_n, 1e6) && below(s.torque_E_nm, 1e6) &&
         s.error >= -1 && s.error < 64 && s.axis >= 0 && s.axis <= 7 && known(s.guided) &&
         std::isfinite(s.value) && std::isfinite(s.limit);
}
bool usable(const RobotCommand& s) {
  return s.robot == 0 && near(s.origin, s.header.time_ns) && below(s.tau_nm, 1e3) &&
         known(s.mode, 3) && below(s.p_WE_desired_m, 5) && below(s.v_WE_desired_m_per_s, 10);
}
bool usable(const RobotMotion& s) {
  return s.robot == 0 && near(s.origin, s.header.time_ns) && known(s.kind, 3) &&
         below(s.q_rad, 10) && below(s.dq_rad_per_s, 100) && below(s.p_WE_m, 5) &&
         (s.kind == c3rt_v2_MOTION_CARTESIAN_POSE ? unit(s.q_WE) : unit_or_none(s.q_WE)) &&
         below(s.v_WE_m_per_s, 10) && below(s.omega_WE_rad_per_s, 100) && known(s.has_elbow) &&
         std::fabs(s.elbow_q3_rad) <= 10 && std::fabs(s.elbow_sign) <= 1 &&
         (!s.has_elbow || std::fabs(s.elbow_sign) == 1) && known(s.finished);
}
/// No contact above its collision, and no collision that any touch would be.
template <std::size_t n>
bool in_order(const double (&contact)[n], const double (&collision)[n]) {
  for (std::size_t i = 0; i < n; ++i) {
    if (!(contact[i] >= 0 && contact[i] <= collision[i])) return false;
    if (!(collision[i] >= 0.1 && collision[i] <= 1e3)) return false;
  }
  return true;
}
bool usable(const RobotOrder& s) {
  if (!known(s.kind, 3) || !known(s.engaged) || !known(s.free_elbow)) return false;
  for (const c3rt_v2_ContactThresholds* t : {&s.acceleration, &s.nominal}) {
    if (s.kind == c3rt_v2_ORDER_THRESHOLDS &&
        !(in_order(t->contact_torque_nm, t->collision_torque_nm) &&
          in_order(t->contact_force_E_n, t->collision_force_E_n) &&
          in_order(t->contact_torque_E_nm, t->collision_torque_E_nm)))
      return false;
  }
  const bool leads_nowhere =
      s.kind == c3rt_v2_ORDER_GUIDING && s.engaged && !s.free_elbow && s.free_axes == 0;
  const bool takes_no_time = s.kind == c3rt_v2_ORDER_PUSH && s.duration_s < 1e-3;
  return s.robot == 0 && s.free_axes < 64 && !leads_nowhere && !takes_no_time &&
         below(s.force_W_n, 200) && s.duration_s >= 0 && s.duration_s <= 60;
}
bool usable(const Plan& s) {
  const double valid_s =
      1e-9 * (static_cast<double>(s.valid_until_ns) - static_cast<double>(s.header.time_ns));
  if (s.knot_count < 1 || s.knot_count > 16) return false;
  for (int i = 0; i < s.knot_count; ++i) {
    const c3rt_v2_Knot& knot = s.knots[i];
    const double ahead_s =
        1e-9 * (static_cast<double>(knot.time_ns) - static_cast<double>(s.header.time_ns));
    if (std::fabs(ahead_s) > 10.001 || (i > 0 && knot.time_ns <= s.knots[i - 1].time_ns) ||
        !below(knot.p_WE_m, 5) || !below(knot.v_WE_m_per_s, 10) || !unit(knot.q_WE) ||
        !below(knot.force_E_n, 1e3))
      return false;
  }
  return s.robot == 0 && near(s.origin, s.header.time_ns) && valid_s >= 0 && valid_s <= 10 &&
         known(s.status, 2) && ends(s.phase) && s.solve_time_s >= 0 &&
         std::isfinite(s.solve_time_s);
}
bool usable(const PlannerDebug& s) {
  const bool counted = s.horizon >= 0 && s.horizon <= 10 && s.state_count >= 0 &&
                       s.state_count <= 48 && s.force_count >= 0 && s.force_count <= 64 &&
                       s.input_count >= 0 && s.input_count <= 4 && s.admm_iterations >= 0 &&
                       s.admm_iterations <= 16 && s.candidate_count >= 0 && s.candidate_count <= 32;
  if (!counted) return false;
  for (int i = 0; i < s.candidate_count; ++i) {
    if (!below(s.candidates[i].p_WE_m, kLargest) || !std::isfinite(s.candidates[i].cost))
      return false;
  }
  return s.robot == 0 && s.object_index >= 0 && s.object_index < 8 && below(s.states, kLargest) &&
         below(s.forces, kLargest) && below(s.inputs, kLargest) && below(s.u_c3, kLargest) &&
         below(s.lambda_d, kLargest) && below(s.primal_residual, kLargest) &&
         below(s.p_WB_target_m, kLargest) && std::isfinite(s.delta_t_c_s) &&
         std::isfinite(s.complementarity_violation);
}
bool usable(const ObjectDetection& s) {
  return s.camera >= 0 && s.camera < 64 && s.object_index >= 0 && s.object_index < 8 &&
         near(s.exposure_ns, s.header.time_ns) && known(s.found) && known(s.used) &&
         std::fabs(s.u_px) <= 1e5 && std::fabs(s.v_px) <= 1e5 && s.radius_px >= 0 &&
         s.radius_px <= 1e5 && below(s.p_WB_m, 10) && unit_or_none(s.q_WB);
}
bool usable(const ObjectEstimate& s) {
  return s.object_index >= 0 && s.object_index < 8 && ends(s.name) &&
         near(s.exposure_ns, s.header.time_ns) && known(s.valid) && s.sensors_used >= 0 &&
         s.sensors_used <= 64 && below(s.p_measured_m, 10) && unit_or_none(s.q_measured) &&
         below(s.p_WB_m, 10) && below(s.v_WB_m_per_s, 20) && below(s.omega_rad_per_s, 2e3) &&
         below(s.a_WB_m_per_s2, 100) && unit(s.q_WB);
}
bool usable(const TaskTarget& s) {
  if (!ends(s.kind) || s.parameter_count < 0 || s.parameter_count > 16) return false;
  for (int i = 0; i < s.parameter_count; ++i) {
    const c3rt_v2_TargetParameter& parameter = s.parameters[i];
    if (!ends(parameter.name) || !ends(parameter.word) || parameter.value_count < 0 ||
        parameter.value_count > 64 || !below(parameter.values, 1e6))
      return false;
  }
  return true;
}
bool usable(const Scene& s) {
  if (s.object_count < 0 || s.object_count > 8) return false;
  for (int i = 0; i < s.object_count; ++i) {
    const c3rt_v2_SceneObject& object = s.objects[i];
    if (!below(object.p_WB_m, 1e6) || !unit(object.q_WB) || !below(object.v_WB_m_per_s, 1e4) ||
        !below(object.omega_rad_per_s, 1e6))
      return false;
  }
  return known(s.exposure) && below(s.q_rad, 10) && below(s.p_WE_m, 5);
}
bool usable(const Tick&) { return true; }  // numbers of any size
bool usable(const Done& s) { return known(s.process, 4); }
bool usable(const ServiceStatus& s) {
  for (const auto& name : s.counter_names)
    if (!ends(name)) return false;
  for (const RefusedSamples& refused : s.refused)
    if (!ends(refused.topic) || !ends(refused.reason) || !ends(refused.latest)) return false;
  const auto finite = [](const Quantiles& q) {
    return std::isfinite(q.p50_s) && std::isfinite(q.p95_s) && std::isfinite(q.p99_s) &&
           std::isfinite(q.p999_s) && std::isfinite(q.max_s);
  };
  return known(s.process, 4) && known(s.state, 4) && ends(s.text) && std::isfinite(s.rate_hz) &&
         finite(s.wakeup_latency) && finite(s.compute);
}
bool usable(const ServiceRequest& s) { return known(s.process, 4) && known(s.verb, 2); }
bool usable(const ServiceReply& s) { return known(s.process, 4) && known(s.ok) && ends(s.text); }
bool usable(const PlannerWeights& s) {
  if (s.weight_count < 0 || s.weight_count > 32) return false;
  for (int i = 0; i < s.weight_count; ++i) {
    if (!ends(s.weights[i].name)) return false;
    if (!(s.weights[i].value >= 0 && s.weights[i].value <= 1e12)) return false;
  }
  return true;
}
bool usable(const FaultInject& s) {
  return known(s.process, 4) && known(s.kind, 6) && s.duration_s >= 0 && s.duration_s <= 3600 &&
         below(s.value, 1e3);
}

// ---- random samples

/// One of the values that break programs, or any bits at all.
void spoil(unsigned char* word, std::size_t size, Random& random) {
  const double numbers[] = {kNaN, kInfinity, -kInfinity, 1e300, -1e300, 1e6, 0.0};
  const std::int32_t counts[] = {-1, 1000000, std::numeric_limits<std::int32_t>::min(),
                                 std::numeric_limits<std::int32_t>::max(), 5};
  switch (random.index(3)) {
    case 0:
      std::memcpy(word, &numbers[random.index(7)], size);
      return;
    case 1:
      std::memcpy(word, &counts[random.index(5)], std::min<std::size_t>(size, 4));
      return;
    default:
      for (std::size_t i = 0; i < size; ++i)
        word[i] = static_cast<unsigned char>(random.index(256));
  }
}

TEMPLATE_LIST_TEST_CASE("validate: what passes is usable, whatever bytes came", "", TopicTypes) {
  constexpr std::size_t kWords = sizeof(TestType) / 8;
  int passed = 0;
  for (int i = 0; i < c3rt::test::property_instances(); ++i) {
    Random random(static_cast<unsigned>(i));
    auto sample = plain<TestType>();
    unsigned char bytes[sizeof(TestType)];
    std::memcpy(bytes, &sample, sizeof bytes);
    if (i % 10 == 9) {
      for (std::size_t k = 0; k < kWords; ++k) spoil(bytes + 8 * k, 8, random);
    } else {
      const int spoiled = random.index(3);
      for (int k = 0; k < spoiled; ++k)
        spoil(bytes + 8 * random.index(static_cast<int>(kWords)), 8, random);
    }
    std::memcpy(&sample, bytes, sizeof sample);
    INFO("instance " << i);
    const Refusal refusal = validate(sample);
    if (refusal) {
      CHECK(refusal.reason == Reason::kValue);
      CHECK_FALSE(to_text(refusal).empty());
    } else {
      ++passed;
      CHECK(usable(sample));
    }
  }
  CHECK(passed > c3rt::test::property_instances() / 5);  // the third that is not spoiled passes
}

template <typename T>
std::string answer(const T& sample) {
  return to_text(validate(sample));
}

TEST_CASE("validate: the finding names the field, what came and what was expected") {
  auto plan = plain<Plan>();
  CHECK(answer(plan).empty());
  plan.knots[0].q_WE[0] = 0.0;
  CHECK(answer(plan) == "zero quaternion knots.q_WE[0]: norm 0, expected 1");
  plan.knots[0].q_WE[0] = 0.5;
  CHECK(answer(plan) == "quaternion knots.q_WE[0]: norm 0.5, expected 1");
  for (const int count : {0, 17, 1000000}) {
    plan = plain<Plan>();
    plan.knot_count = count;
    CHECK(answer(plan) == "knot_count is " + std::to_string(count) + ", expected 1 to 16");
  }
  plan = plain<Plan>();
  plan.knots[0].force_E_n[2] = -1e9;
  CHECK(answer(plan) == "knots.force_E_n[2] is -1000000000, expected -1000 to 1000");
  plan = plain<Plan>();
  plan.valid_until_ns = std::numeric_limits<std::int64_t>::max();
  CHECK_THAT(answer(plan), Catch::StartsWith("valid_until_ns after time_ns in seconds is 9.2"));
  plan = plain<Plan>();
  plan.knots[1].p_WE_m[1] = kNaN;  // what is not used may be anything
  CHECK(answer(plan).empty());
  plan.knot_count = 2;
  CHECK(answer(plan) == "knots.p_WE_m[1] is nan, expected -5 to 5");
  plan.knots[1].p_WE_m[1] = 0.0;
  CHECK_THAT(answer(plan),
             Catch::StartsWith("knots.time_ns after the knot before in seconds[1] is 0"));
  plan.knots[1].time_ns = 1;
  CHECK(answer(plan).empty());
  plan.phase[0] = '\n';
  CHECK_THAT(answer(plan), Catch::StartsWith("phase is no text"));

  auto debug = plain<PlannerDebug>();
  debug.horizon = 11;
  CHECK(answer(debug) == "horizon is 11, expected 0 to 10");
  debug = plain<PlannerDebug>();
  debug.states[479] = kNaN;
  CHECK(answer(debug) == "states[479] is nan, expected a finite number");
  debug = plain<PlannerDebug>();
  debug.candidate_count = 33;
  CHECK(answer(debug) == "candidates is 33, expected 0 to 32");
  auto scene = plain<Scene>();
  scene.object_count = -1;
  CHECK(answer(scene) == "object_count is -1, expected 0 to 8");
  auto estimate = plain<ObjectEstimate>();
  estimate.p_WB_m[2] = 1e300;
  CHECK(answer(estimate) == "p_WB_m[2] is 1e+300, expected -10 to 10");
  estimate = plain<ObjectEstimate>();
  estimate.exposure_ns = std::numeric_limits<std::int64_t>::min();
  CHECK_THAT(answer(estimate), Catch::StartsWith("exposure_ns is -9.2"));
  auto state = plain<RobotState>();
  state.robot = 7;
  CHECK(answer(state) == "robot is 7, expected 0");
  ServiceReply reply{};
  std::memset(reply.text, 'x', sizeof reply.text);
  CHECK(answer(reply) == "text is no text: expected at most 511 printable letters and an end");
  std::strcpy(reply.text, "\x1b[2J");
  CHECK_FALSE(answer(reply).empty());
  FaultInject fault{};
  fault.value[0] = kNaN;
  CHECK(answer(fault) == "value[0] is nan, expected -1000 to 1000");
}

TEST_CASE("validate: what nobody can order of the robot is named") {
  RobotOrder order{};
  CHECK(answer(order).empty());  // a hand that lets go
  order.engaged = true;
  CHECK(answer(order) == "free_axes is 0, expected 1 to 63");
  order.free_axes = 64;
  CHECK(answer(order) == "free_axes is 64, expected 1 to 63");
  order.free_axes = 0;
  order.free_elbow = true;
  CHECK(answer(order).empty());
  order = {};
  order.kind = c3rt_v2_ORDER_PUSH;
  CHECK(answer(order) == "duration_s is 0, expected 0.001 to 60");
  order.duration_s = 1.0;
  order.force_W_n[1] = -201.0;
  CHECK(answer(order) == "force_W_n[1] is -201, expected -200 to 200");
  order = {};
  order.kind = c3rt_v2_ORDER_THRESHOLDS;
  CHECK(answer(order) == "acceleration.collision_torque_nm[0] is 0, expected 0.1 to 1000");
  for (c3rt_v2_ContactThresholds* t : {&order.acceleration, &order.nominal}) {
    std::fill(std::begin(t->collision_torque_nm), std::end(t->collision_torque_nm), 20.0);
    std::fill(std::begin(t->collision_force_E_n), std::end(t->collision_force_E_n), 30.0);
    std::fill(std::begin(t->collision_torque_E_nm), std::end(t->collision_torque_E_nm), 5.0);
  }
  CHECK(answer(order).empty());
  order.nominal.contact_torque_nm[6] = 20.5;
  CHECK(answer(order) == "nominal.contact_torque_nm[6] is 20.5, expected 0 to 20");
  order.nominal.contact_torque_nm[6] = 20.0;
  order.acceleration.contact_force_E_n[2] = kNaN;
  CHECK(answer(order) == "acceleration.contact_force_E_n[2] is nan, expected 0 to 30");
  order.acceleration.contact_force_E_n[2] = 0.0;
  order.nominal.collision_torque_E_nm[0] = kInfinity;
  CHECK(answer(order) == "nominal.collision_torque_E_nm[0] is inf, expected 0.1 to 1000");
}

TEST_CASE("validate: a pose that is commanded has a rotation, other motions need none") {
  RobotMotion motion{};
  CHECK(answer(motion).empty());
  motion.kind = c3rt_v2_MOTION_CARTESIAN_POSE;
  CHECK(answer(motion) == "zero quaternion q_WE: norm 0, expected 1");
  motion.q_WE[2] = -1.0;
  CHECK(answer(motion).empty());
  motion.elbow_sign = -1.5;
  CHECK(answer(motion) == "elbow_sign is -1.5, expected -1 to 1");
  motion.elbow_sign = 0.5;  // not used
  CHECK(answer(motion).empty());
  motion.has_elbow = true;
  CHECK(answer(motion) == "|elbow_sign| is 0.5, expected 1");
  motion.elbow_sign = 0.0;
  CHECK(answer(motion) == "|elbow_sign| is 0, expected 1");
  motion.elbow_sign = 1.0;
  CHECK(answer(motion).empty());
  motion.elbow_sign = -1.0;
  CHECK(answer(motion).empty());
  motion.dq_rad_per_s[3] = kNaN;  // a reader lets no number in that is none, of whatever kind
  CHECK(answer(motion) == "dq_rad_per_s[3] is nan, expected -100 to 100");
}

TEST_CASE("validate: a header's sequence begins at 1 and its time is not far ahead") {
  constexpr std::int64_t kNow = 5'000'000'000;
  constexpr std::int64_t kLatest = kNow + kAhead_ns;
  CHECK_FALSE(validate(Header{1, 1, kNow}, true, kLatest));
  CHECK_FALSE(validate(Header{1, 1, kLatest}, true, kLatest));
  CHECK(validate(Header{1, 0, kNow}, true, kLatest).reason == Reason::kHeader);
  CHECK(validate(Header{1, ~0ull, kNow}, true, kLatest).reason == Reason::kHeader);
  CHECK(validate(Header{1, 1, kLatest + 1}, true, kLatest).reason == Reason::kHeader);
  CHECK(validate(Header{1, 1, -1}, true, kLatest).reason == Reason::kHeader);
  // a client's request may come from a host with another clock
  CHECK_FALSE(validate(Header{0, 1, kNow + 3600 * kAhead_ns}, false, kLatest));
}

}  // namespace
