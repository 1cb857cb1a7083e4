#pragma once
// The emulated sensor: ground truth at the exposure plus noise, as in the paper's simulation
// (VII-A).
#include <cstdint>

#include <Eigen/Geometry>

#include "controller/base/random.hpp"
#include "vision/parameters.hpp"

namespace c3rt::vision {

/// Adds N(0, noise) on x and y, clipped to ±clip; z stays exact, as on a table of known height.
class EmulatedSensor {
 public:
  EmulatedSensor(const EmulatedParameters& parameters, std::uint64_t seed)
      : parameters_(parameters), random_(seed) {}
  /// @param p_WB the true position [m]
  Eigen::Vector3d measure(const Eigen::Vector3d& p_WB) noexcept;
  /// The same of an orientation, about z.
  Eigen::Quaterniond measure(const Eigen::Quaterniond& q_WB) noexcept;

 private:
  EmulatedParameters parameters_;
  base::Random random_;
};

}  // namespace c3rt::vision
