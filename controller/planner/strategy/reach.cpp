#include "controller/planner/strategy/reach.hpp"

#include <algorithm>

#include "controller/planner/strategy/surface_samples.hpp"

namespace c3rt::planner {

BodyReach::BodyReach(const SamplingParameters& sampling, const scene::Body& body,
                     double effector_radius) noexcept {
  const double beside = effector_radius + sampling.clearance;
  const auto room = [&](double x, double y) { return extent(body, {x, y, 0.0}) + beside; };
  box_ = {Eigen::Vector2d(sampling.reach_min + Eigen::Vector2d(room(-1, 0), room(0, -1))),
          Eigen::Vector2d(sampling.reach_max - Eigen::Vector2d(room(1, 0), room(0, 1)))};
  const Eigen::Vector2d out = body.p_WB.head<2>().stableNormalized();
  radius_ = sampling.reach_radius - room(out.x(), out.y());
}

double BodyReach::beyond(const Eigen::Vector2d& p_WB) const noexcept {
  return std::max(box_.exteriorDistance(p_WB), p_WB.norm() - radius_);
}

}  // namespace c3rt::planner
