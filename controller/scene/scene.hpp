#pragma once
// What is where at one instant: the end effector and the bodies that it may touch.
#include <array>

#include <Eigen/Geometry>

namespace c3rt::scene {

/// The most bodies in a scene; all of them have room in it, so that a scene is copied without heap.
constexpr int kMaxBodies = 8;

/// A rigid body. Nothing in it is aligned for a vector unit, which would give it another layout for
/// each.
struct Body {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // of its centre of mass, in W [m]
  Eigen::Quaternion<double, Eigen::DontAlign> q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();      // [m/s]
  Eigen::Vector3d omega_WB = Eigen::Vector3d::Zero();  // in W [rad/s]
  // in x and y with nothing but the table in contact: how a tilted table accelerates it [m/s²]
  Eigen::Matrix<double, 2, 1, Eigen::DontAlign> a_WB = Eigen::Vector2d::Zero();
};

struct Effector {
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero();  // of its centre, in W [m]
  Eigen::Vector3d v_WE = Eigen::Vector3d::Zero();  // [m/s]
};

struct Scene {
  Effector effector;
  int body_count = 0;
  std::array<Body, kMaxBodies> bodies;  // the first body_count of them

  Body& body(int i) noexcept { return bodies[static_cast<std::size_t>(i)]; }
  const Body& body(int i) const noexcept { return bodies[static_cast<std::size_t>(i)]; }
};

}  // namespace c3rt::scene
