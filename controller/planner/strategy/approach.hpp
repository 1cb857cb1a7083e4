#pragma once
// The end effector's ways without C3: to above a body, and up out of the cameras' way.
#include <Eigen/Core>

#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// What the way is walked with, in one period.
struct ApproachInput {
  double now;            // session time [s]
  double period;         // since the last call [s]
  Eigen::Vector3d p_WE;  // the end effector [m]
  bool follows = true;   // the robot moves and tracks the plans
};

/// A reference that starts and ends gently, as one whose velocity jumps drives a stiff arm into its
/// torque limits. While the robot does not follow (stopped by a person, a reflex, its controller
/// holds or is not there) it rests where the arm is, so that an arm that moves again finds it
/// there. An arm that follows but stays behind (something is in its way) it waits for.
class Approach {
 public:
  /// @param table_height in W [m]
  Approach(const ApproachParameters& parameters, double table_height);

  /// Anew from here, at rest.
  void begin(const Eigen::Vector3d& p_WE) noexcept;
  /// One period's step up, across and down to above a body, never through one.
  void to_body(const ApproachInput& input, const Eigen::Vector3d& p_WB) noexcept;
  /// One period's step up, to where it can start again from.
  void out_of_the_way(const ApproachInput& input) noexcept;

  /// Whether the end effector has been above the body for the settling time.
  bool settled(double now) const noexcept;
  const Eigen::Vector3d& reference() const noexcept { return reference_; }  // in W [m]
  const Eigen::Vector3d& velocity() const noexcept { return velocity_; }    // of it [m/s]

 private:
  void advance(const ApproachInput& input, const Eigen::Vector3d& goal) noexcept;

  ApproachParameters parameters_;
  double safe_;  // height, in W [m]
  Eigen::Vector3d reference_ = Eigen::Vector3d::Zero(), velocity_ = Eigen::Vector3d::Zero();
  bool descending_ = false;      // the last part of the way
  double settled_since_ = -1.0;  // negative: not yet [s]
};

}  // namespace c3rt::planner
