#pragma once
// From where the end effector can bring a body back.
#include "controller/planner/parameters.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

/// A body farther out than this can be pushed no nearer, as the end effector does not come behind
/// it.
class BodyReach {
 public:
  /// @param body as it lies now; turned otherwise it may be wider
  BodyReach(const SamplingParameters& sampling, const scene::Body& body,
            double effector_radius) noexcept;

  /// How far a body whose origin is there is outside; 0 inside [m].
  double beyond(const Eigen::Vector2d& p_WB) const noexcept;

 private:
  Eigen::AlignedBox2d box_;  // in W [m]
  double radius_;            // about the robot's base [m]
};

}  // namespace c3rt::planner
