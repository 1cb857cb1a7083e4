#include "idl/client/motion.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "controller/base/time.hpp"
#include "controller/base/words.hpp"
#include "idl/client/settings.hpp"
#include "idl/text.hpp"
#include "idl/validate.hpp"

namespace c3rt::client {
namespace {

// two states of a robot at 1 kHz are too near each other for a velocity
constexpr std::int64_t kVelocityOver_ns = 4'000'000;
constexpr double kLongest = 10.0;  // of a plan [s]
constexpr std::size_t kLongestPhase = sizeof(wire::Plan::phase) - 1;

template <std::size_t n>
std::array<double, n> array(const double (&values)[n]) {
  std::array<double, n> out{};
  std::copy(values, values + n, out.begin());
  return out;
}

void fill_knot(c3rt_v2_Knot& out, const Knot& knot) {
  fill(out.p_WE_m, knot.p);
  fill(out.v_WE_m_per_s, knot.v);
  fill(out.force_E_n, knot.force);
  fill_unit(out.q_WE, knot.q);
}

}  // namespace

void Observations::add(const wire::RobotState& state) {
  // another session's time is another one
  if (!states_.empty() && state.header.time_ns <= states_.back().header.time_ns) states_.clear();
  states_.push_back(state);
  while (states_.size() > 2 && state.header.time_ns - states_[1].header.time_ns >= kVelocityOver_ns)
    states_.pop_front();
}

Situation Observations::situation(std::int64_t now_ns) const {
  const wire::RobotState &state = states_.back(), &before = states_.front();
  Situation now;
  now.time = base::seconds(now_ns);
  now.effector.p = array(state.p_WE_m);
  const double since = base::seconds(state.header.time_ns - before.header.time_ns);
  for (std::size_t i = 0; since > 0.0 && i < now.effector.v.size(); ++i)
    now.effector.v[i] = (state.p_WE_m[i] - before.p_WE_m[i]) / since;
  now.effector.q = array(state.q_rad);
  now.effector.dq = array(state.dq_rad_per_s);
  now.effector.moves = state.mode == c3rt_v2_ROBOT_MOVE || state.mode == c3rt_v2_ROBOT_IDLE;
  for (const auto& [index, seen] : estimates_) {
    now.objects[index] = {seen.name,
                          seen.valid,
                          array(seen.p_WB_m),
                          array(seen.q_WB),
                          array(seen.v_WB_m_per_s),
                          array(seen.omega_rad_per_s),
                          base::seconds(now_ns - seen.exposure_ns)};
  }
  return now;
}

wire::Origin Observations::origin() const {
  wire::Origin origin{};
  origin.state_ns = states_.back().header.time_ns;
  if (estimates_.empty()) return origin;
  origin.exposure_ns = estimates_.begin()->second.exposure_ns;
  origin.estimate_ns = estimates_.begin()->second.header.time_ns;
  return origin;
}

wire::Plan plan_sample(const Motion& motion, std::int64_t effective_ns, double valid_for) {
  const std::size_t count = motion.knots.size();
  if (count < 1 || count > c3rt_v2_MAX_KNOTS) {
    throw std::invalid_argument(
        base::words("knots: expected 1 to %d, got %zu", c3rt_v2_MAX_KNOTS, count));
  }
  if (motion.phase.empty() || motion.phase.size() > kLongestPhase) {
    throw std::invalid_argument("phase: expected a text of 1 to " + std::to_string(kLongestPhase) +
                                " bytes, got \"" + motion.phase + "\"");
  }
  wire::Plan plan{};
  plan.status = c3rt_v2_PLAN_OK;
  wire::set_text(plan.phase, motion.phase);
  plan.valid_until_ns = effective_ns + base::nanoseconds(valid_for);
  plan.knot_count = static_cast<std::int32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Knot& knot = motion.knots[i];
    if (!(knot.after >= 0.0 && knot.after <= kLongest)) {
      throw std::invalid_argument(
          base::words("knots[%zu].after: expected 0 to %g s, got %g", i, kLongest, knot.after));
    }
    plan.knots[i].time_ns = effective_ns + base::nanoseconds(knot.after);
    fill_knot(plan.knots[i], knot);
  }
  // the readers would refuse it
  plan.header.time_ns = effective_ns;
  if (const wire::Refusal refused = wire::validate(plan))
    throw std::invalid_argument(to_text(refused));
  return plan;
}

}  // namespace c3rt::client
