#pragma once
// The emulated sensor: ground truth at the exposure plus noise, as in the paper's simulation
// (VII-A).
#include <cstdint>
#include <random>

#include <Eigen/Core>

#include "vision/parameters.hpp"

namespace c3rt::vision {

/// Standard normal numbers by Box and Muller's transform of mt19937_64. The distributions of
/// <random> differ between standard libraries; this is the same sequence wherever log, cos and sin
/// are.
class NormalSequence {
 public:
  explicit NormalSequence(std::uint64_t seed) : engine_(seed) {}
  double next() noexcept;

 private:
  double uniform() noexcept;  // in (0, 1]

  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// Adds N(0, noise) on x and y, clipped to ±clip; z stays exact, as on a table of known height.
class EmulatedSensor {
 public:
  EmulatedSensor(const EmulatedParameters& parameters, std::uint64_t seed)
      : parameters_(parameters), normal_(seed) {}
  /// @param p_WB the true position [m]
  Eigen::Vector3d measure(const Eigen::Vector3d& p_WB) noexcept;

 private:
  EmulatedParameters parameters_;
  NormalSequence normal_;
};

}  // namespace c3rt::vision
