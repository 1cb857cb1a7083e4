#pragma once
// A planned motion of the end effector as knots in time, and where it is between them. Pure.
#include <array>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/impedance/law.hpp"

namespace c3rt::impedance {

constexpr int kMaxKnots = 16;

struct Knot {
  std::int64_t time_ns = 0;
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d v_WE = Eigen::Vector3d::Zero();  // [m/s]
  // nothing in it is aligned for a vector unit
  Eigen::Quaternion<double, Eigen::DontAlign> q_WE = Eigen::Quaterniond::Identity();
  // that the contacts exert on the end effector, in W [N]
  Eigen::Vector3d force_E = Eigen::Vector3d::Zero();
};
using Knots = std::array<Knot, kMaxKnots>;

/// The motion at that time. A single knot is a goal without a motion: it is followed as it is. Of
/// several, p and v are the cubic with the positions and velocities of the two knots around
/// (Hermite), q the shortest rotation at constant rate (slerp), the force linear between them;
/// before the first knot it is the first, after the last one the position, orientation and force of
/// the last at rest.
/// @param count 1 to kMaxKnots; the times of the knots grow
/// RT: no heap, no lock, no throw.
Goal interpolate(const Knots& knots, int count, std::int64_t now_ns) noexcept;

/// Between 1 and kMaxKnots of them, and their times grow. RT: no heap, no lock, no throw.
bool are_ordered(const Knots& knots, int count) noexcept;

}  // namespace c3rt::impedance
