#pragma once
// What is where at one instant: the end effector and the bodies that it may touch.
#include <array>
#include <cstring>

#include <Eigen/Geometry>

#include "controller/scene/shape.hpp"

namespace c3rt::scene {

/// The most bodies in a scene; all of them have room in it, so that a scene is copied without heap.
constexpr int kMaxBodies = 8;

/// A body's name, of fixed size.
class Name {
 public:
  Name() = default;
  /// Cut off where it is too long.
  Name(const char* text) noexcept { std::strncpy(text_, text, sizeof text_ - 1); }  // NOLINT
  const char* c_str() const noexcept { return text_; }

 private:
  char text_[32] = {};
};

/// A rigid body. Nothing in it is aligned for a vector unit, which would give it another layout for
/// each.
struct Body {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // of its centre of mass, in W [m]
  Eigen::Quaternion<double, Eigen::DontAlign> q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();      // [m/s]
  Eigen::Vector3d omega_WB = Eigen::Vector3d::Zero();  // in W [rad/s]
  // in x and y with nothing but the table in contact: how a tilted table accelerates it [m/s²]
  Eigen::Matrix<double, 2, 1, Eigen::DontAlign> a_WB = Eigen::Vector2d::Zero();
  Shape shape = {};  // about p_WB
  Name name = {};
};

/// The end effector: a sphere.
struct Effector {
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero();  // of its centre, in W [m]
  Eigen::Vector3d v_WE = Eigen::Vector3d::Zero();  // [m/s]
  double radius = 0.0;                             // [m]
};

struct Scene {
  Effector effector;
  double table_height = 0.0;  // of the table's surface, in W [m]
  int body_count = 0;
  std::array<Body, kMaxBodies> bodies;  // the first body_count of them

  Body& body(int i) noexcept { return bodies[static_cast<std::size_t>(i)]; }
  const Body& body(int i) const noexcept { return bodies[static_cast<std::size_t>(i)]; }
};

/// The end effector as seen from a body's surface.
struct Gap {
  double distance;         // between the surfaces, negative where they overlap [m]
  Eigen::Vector3d normal;  // from the body to the end effector, in W
};
Gap gap(const Effector& effector, const Body& body) noexcept;

/// Moves a sphere horizontally away from the end effector until they touch, where they overlap
/// [Algorithm 3, step 1: an estimate with the end effector inside would make the LCS push them
/// apart at once].
/// @param away horizontal direction used when the end effector is straight above it
void separate(const Effector& effector, const Eigen::Vector3d& away, Body& sphere) noexcept;

/// The angle of a body about z: of its rotation without tilt, −π … π [rad].
double yaw(const Body& body) noexcept;

}  // namespace c3rt::scene
