#include "controller/planner/strategy/approach.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::planner {
namespace {

constexpr double kRest = 0.5;          // of the tolerance: a goal nearer than this is reached
constexpr double kAcceleration = 1.0;  // of the reference [m/s²]

}  // namespace

Approach::Approach(const ApproachParameters& parameters, double table_height)
    : parameters_(parameters), safe_(table_height + parameters.safe_height) {}

void Approach::begin(const Eigen::Vector3d& p_WE) noexcept {
  reference_ = p_WE;
  velocity_.setZero();
  descending_ = false;
  settled_since_ = -1.0;
}

void Approach::to_body(const ApproachInput& input, const Eigen::Vector3d& p_WB) noexcept {
  const double tolerance = parameters_.tolerance;
  const Eigen::Vector3d start(p_WB.x(), p_WB.y(), p_WB.z() + parameters_.start_height);
  // a way down once begun is not given up for the noise of the estimate
  const double beside = (reference_ - start).head<2>().norm();
  descending_ = beside < (descending_ ? 2.0 * tolerance : tolerance);
  Eigen::Vector3d goal = start;
  if (!descending_ && reference_.z() < safe_ - tolerance) {
    goal << reference_.x(), reference_.y(), safe_;
  } else if (!descending_) {
    goal.z() = safe_;
  }
  // nor does an arm that rests near enough chase it
  const bool rests = velocity_.isZero(0.0) && (goal - reference_).norm() < kRest * tolerance;
  advance(input, rests ? reference_ : goal);
  if (!input.follows || (input.p_WE - start).norm() > tolerance) {
    settled_since_ = -1.0;
  } else if (settled_since_ < 0.0) {
    settled_since_ = input.now;
  }
}

void Approach::out_of_the_way(const ApproachInput& input) noexcept {
  advance(input, {reference_.x(), reference_.y(), std::max(reference_.z(), safe_)});
}

bool Approach::settled(double now) const noexcept {
  return settled_since_ >= 0.0 && now - settled_since_ >= parameters_.settle_time;
}

void Approach::advance(const ApproachInput& input, const Eigen::Vector3d& goal) noexcept {
  if (!input.follows) {
    reference_ = input.p_WE;
    velocity_.setZero();
    return;
  }
  const Eigen::Vector3d lead = reference_ - input.p_WE;
  if (lead.norm() > parameters_.leash) {
    // an arm that is kept back, by its workspace say, never comes nearer: both would wait for ever
    reference_ = input.p_WE + lead * (parameters_.leash / lead.norm());
    velocity_.setZero();
  }
  const Eigen::Vector3d way = goal - reference_;
  const double to_go = way.norm();
  const double step = kAcceleration * input.period;  // of the speed
  const double speed = std::min(parameters_.speed, velocity_.norm() + step);
  // the speed from which the rest of the way is enough to stop
  const double stopping = std::sqrt(2.0 * kAcceleration * to_go);
  if (to_go <= std::min(speed, stopping) * input.period) {
    reference_ = goal;
    velocity_.setZero();
    return;
  }
  const Eigen::Vector3d wanted = way * (std::min(speed, stopping) / to_go);
  const Eigen::Vector3d change = wanted - velocity_;
  velocity_ += change * std::min(1.0, 2.0 * step / std::max(change.norm(), 1e-12));
  reference_ += velocity_ * input.period;
}

}  // namespace c3rt::planner
