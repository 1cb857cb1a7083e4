#include "controller/planner/strategy/rest.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::planner {
namespace {

constexpr double kHover = 4e-3;      // between end effector and sphere on the way to it [m]
constexpr double kNearGap = 1.5e-3;  // from so near it sinks at once, [m]
constexpr double kNearBeside = 0.025 / 0.0315;  // not farther beside the sphere's top, in radii
constexpr double kAbove = 4e-3;                 // and from hovering no farther than this [m]
constexpr double kClosing = 6.0;                // speed per distance on the way to the sphere [1/s]
constexpr double kCentring = 2.0;               // and while it sinks [1/s]
constexpr double kClosingSpeed = 0.15;          // on top of the sphere's [m/s]
constexpr double kRate = 2.0;                   // of the reference's velocity [m/s²]
constexpr double kSmoothing = 0.08;             // of the sphere's velocity [s]
constexpr double kSinking = 0.01;               // [m/s]
constexpr double kStopped = 2.5e-3;    // it stands on something where it sinks slower [m/s]
constexpr double kStoppedTime = 0.04;  // for this long [s]
constexpr double kMissed = 0.02;       // sunk this far below the sphere's top: beside it [m]
constexpr double kBraking = 1.0;       // of the reference [m/s²]
constexpr double kPress = 3.0;         // while the sphere is stopped [N]
constexpr double kStill = 1e-3;        // an end effector slower than this stands still [m/s]
constexpr double kStand = 0.3;         // it has to stand still for this long [s]
constexpr double kOffGap = 6e-3;       // the sphere is seen to have gone [m]
constexpr double kAtGoal = 2e-3;       // nearer than this the sphere is there [m]
constexpr double kCarryReach = 0.015;  // and from farther it is not carried, as it would slip [m]
constexpr double kCarrySpeed = 0.03;   // [m/s]
constexpr double kRelease = 0.5;       // the press fades over this time [s]
constexpr double kClear = 3e-3;        // rises this far before it is off the sphere [m]
constexpr double kRiseSpeed = 0.01;    // [m/s]
constexpr double kRiseRate = 0.02;     // a jerk would kick the sphere [m/s²]

}  // namespace

Rest::Rest(double end_effector_radius, double leash)
    : end_effector_radius_(end_effector_radius), leash_(leash) {}

void Rest::enter(Stage stage, double now) noexcept {
  stage_ = stage;
  since_ = still_since_ = now;
}

double Rest::gap(const RestInput& input) const noexcept {
  return (input.p_WE - input.p_WB).norm() - input.radius - end_effector_radius_;
}

void Rest::begin(const RestInput& input) noexcept {
  // where the sphere is not seen, the end effector is on it
  enter(input.seen ? Stage::kMeet : Stage::kTouch, input.now);
  reference_ = input.p_WE;
  velocity_ = input.v_WE;
  v_WB_ = input.v_WB.head<2>();
  press_ = 0.0;
  stopped_ = false;
}

void Rest::advance(const RestInput& input, const Eigen::Vector3d& velocity) noexcept {
  const Eigen::Vector3d lead = reference_ - input.p_WE;
  if (lead.norm() > leash_) {
    reference_ = input.p_WE + lead * (leash_ / lead.norm());
    velocity_.setZero();
  }
  const Eigen::Vector3d change = velocity - velocity_;
  const double most = kRate * input.period;
  velocity_ += change * std::min(1.0, most / std::max(change.norm(), 1e-12));
  reference_ += velocity_ * input.period;
}

void Rest::meet(const RestInput& input) noexcept {
  const double beside = (input.p_WE - input.p_WB).head<2>().norm();
  const double top = input.p_WB.z() + input.radius + end_effector_radius_;
  const bool near = gap(input) < kNearGap && beside < kNearBeside * input.radius;
  from_above_ =
      beside < kAbove && input.p_WE.z() > top + 0.5 * kHover && input.p_WE.z() < top + 2.0 * kHover;
  if (from_above_ || (near && !stopped_)) {
    enter(Stage::kTouch, input.now);
    touch(input);
    return;
  }
  // up before across, as the sphere is not to be pushed
  Eigen::Vector3d way(input.p_WB.x(), input.p_WB.y(), top + kHover);
  way -= reference_;
  if (beside > kAbove && way.z() > 0.5 * kHover) way.head<2>().setZero();
  Eigen::Vector3d wanted = kClosing * way;
  if (wanted.norm() > kClosingSpeed) wanted *= kClosingSpeed / wanted.norm();
  wanted.head<2>() += v_WB_;
  advance(input, wanted);
}

void Rest::touch(const RestInput& input) noexcept {
  press_ = kPress;
  carried_ = false;
  Eigen::Vector3d wanted(v_WB_.x(), v_WB_.y(), -kSinking);
  if (input.seen) wanted.head<2>() += kCentring * (input.p_WB - reference_).head<2>();
  advance(input, wanted);
  reference_.z() = input.p_WE.z();
  if (input.v_WE.z() < -kStopped || input.now - since_ < kStoppedTime) still_since_ = input.now;
  if (input.now - still_since_ >= kStoppedTime) {
    enter(Stage::kBrake, input.now);
  } else if (input.p_WE.z() < input.p_WB.z() + input.radius + end_effector_radius_ - kMissed) {
    enter(input.seen ? Stage::kMeet : Stage::kFailed, input.now);
    press_ = 0.0;
  }
}

bool Rest::carry(const RestInput& input) noexcept {
  if (!input.goal || !input.seen || carried_) return false;
  const Eigen::Vector2d way = *input.goal - input.p_WB.head<2>();
  const Eigen::Vector2d beside = (input.p_WE - input.p_WB).head<2>() + way;  // at its end
  if (way.norm() < kAtGoal || way.norm() > kCarryReach ||
      beside.norm() > kNearBeside * input.radius)
    return false;
  carry_to_ = input.p_WE.head<2>() + 2.0 * way;
  carried_ = true;
  enter(Stage::kCarry, input.now);
  return true;
}

void Rest::stand(const RestInput& input) noexcept {
  reference_.z() = input.p_WE.z();
  if (input.v_WE.norm() > kStill) still_since_ = input.now;
  if (input.seen && gap(input) > kOffGap) {
    begin(input);
  } else if (input.now - still_since_ >= kStand && !carry(input)) {
    enter(Stage::kRelease, input.now);
  }
}

void Rest::step(const RestInput& input) noexcept {
  if (input.seen)
    v_WB_ += std::min(1.0, input.period / kSmoothing) * (input.v_WB.head<2>() - v_WB_);
  switch (stage_) {
    case Stage::kMeet:
      if (input.seen) {
        meet(input);
      } else {
        enter(Stage::kFailed, input.now);
      }
      break;
    case Stage::kTouch:
      touch(input);
      break;
    case Stage::kBrake: {
      velocity_.z() = 0.0;
      const double speed = velocity_.norm();
      const double slower = std::max(0.0, speed - kBraking * input.period);
      velocity_ *= speed > 0.0 ? slower / speed : 0.0;
      reference_ += velocity_ * input.period;
      reference_.z() = input.p_WE.z();
      if (slower == 0.0) enter(Stage::kStand, input.now);
      break;
    }
    case Stage::kStand:
      stand(input);
      break;
    case Stage::kCarry: {
      const Eigen::Vector2d way = carry_to_ - reference_.head<2>();
      const double to_go = way.norm();
      const double speed = std::min(kCarrySpeed, std::sqrt(kBraking * to_go));
      if (to_go <= speed * input.period) {
        reference_.head<2>() = carry_to_;
        velocity_.setZero();
        enter(Stage::kStand, input.now);
      } else {
        advance(input, {speed * way.x() / to_go, speed * way.y() / to_go, 0.0});
      }
      reference_.z() = input.p_WE.z();
      break;
    }
    case Stage::kRelease:
      stopped_ = true;
      press_ = std::max(0.0, kPress * (1.0 - (input.now - since_) / kRelease));
      if (press_ == 0.0) {
        enter(Stage::kRise, input.now);
      }
      break;
    case Stage::kRise: {
      const double before = velocity_.z();
      velocity_.z() = std::min(kRiseSpeed, before + kRiseRate * input.period);
      reference_.z() += velocity_.z() * input.period;
      const double time = input.now - since_;
      const double risen = kRiseSpeed * (time - 0.5 * kRiseSpeed / kRiseRate);
      if (risen < kClear) break;
      // a sphere that was stopped from beside its top keeps a spin that makes it creep: once more
      if (carried_) from_above_ = false;
      enter(!from_above_ && input.seen ? Stage::kMeet : Stage::kLeft, input.now);
      break;
    }
    case Stage::kLeft:
    case Stage::kFailed:
      velocity_.setZero();
      break;
  }
}

}  // namespace c3rt::planner
