#include "controller/planner/availability.hpp"

#include <cmath>

namespace c3rt::planner {
namespace {

constexpr double kStateTimeout = 0.1;  // [s]

bool finite(const scene::Body& body) {
  return body.p_WB.allFinite() && body.v_WB.allFinite() && body.omega_WB.allFinite() &&
         body.a_WB.allFinite() && body.q_WB.coeffs().allFinite();
}

bool within(const ApproachParameters& reach, const Eigen::Vector2d& body) {
  return (body.array() >= reach.reach_min.array()).all() &&
         (body.array() <= reach.reach_max.array()).all();
}

Cause hindrance(const Parameters& parameters, const BodyInput& body) {
  if (std::isinf(body.age)) return Cause::kNoVision;
  if (body.age > parameters.estimate_timeout) return Cause::kVisionSilent;
  if (!body.seen) return Cause::kBodyNotInView;
  if (!finite(body.body)) return Cause::kBodyNotFinite;
  if (!within(parameters.approach, body.body.p_WB.head<2>())) return Cause::kBodyOutOfReach;
  return Cause::kNone;
}

}  // namespace

bool Availability::state() const noexcept {
  return cause != Cause::kNoState && cause != Cause::kStateLate && cause != Cause::kStateNotFinite;
}

Availability available(const Parameters& parameters, const Input& input) noexcept {
  if (std::isinf(input.state_age)) return {Cause::kNoState};
  if (input.state_age > kStateTimeout) return {Cause::kStateLate};
  if (!input.effector.p_WE.allFinite() || !input.effector.v_WE.allFinite())
    return {Cause::kStateNotFinite};
  for (int i = 0; i < parameters.model.bodies; ++i) {
    const Cause cause = hindrance(parameters, input.bodies[static_cast<std::size_t>(i)]);
    if (cause != Cause::kNone) return {cause, i};
  }
  return {Cause::kNone};
}

bool in_view(const Parameters& parameters, const BodyInput& body) noexcept {
  const Cause cause = hindrance(parameters, body);
  return cause == Cause::kNone || cause == Cause::kBodyOutOfReach;
}

}  // namespace c3rt::planner
