#pragma once
// How far apart two bodies are.
#include <Eigen/Geometry>

#include "controller/scene/shape.hpp"

namespace c3rt::scene {

/// Two bodies as seen from the second one's surface, in W.
struct Separation {
  double distance;          // between the surfaces, negative where they overlap [m]
  Eigen::Vector3d normal;   // from the second body to the first
  Eigen::Vector3d p_first;  // the nearest point of the first's surface; the second's is
                            // p_first − distance normal
};

/// A shape's place: its origin and axes in W.
struct Place {
  Eigen::Vector3d p;
  Eigen::Matrix3d R;
};

/// Exact where they are apart, to rounding (round shapes whose sides face each other: to 1 µm).
/// Where they overlap, the least way apart along a normal of a face of either, which is exact for
/// faces that overlap and never too small.
Separation separation(const Shape& first, const Place& of_first, const Shape& second,
                      const Place& of_second) noexcept;

}  // namespace c3rt::scene
