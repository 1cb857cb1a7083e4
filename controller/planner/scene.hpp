#pragma once
// What the planner knows of the world: end effector and balls, at one instant.
#include <array>

#include <Eigen/Geometry>

namespace c3rt::planner {

constexpr int kMaxBalls = 4;

struct Ball {
  Eigen::Vector3d p_WB, v_WB;  // [m, m/s]
  Eigen::Vector3d omega_WB;    // in W [rad/s]
  Eigen::Quaterniond q_WB;
  Eigen::Vector2d a_WB = Eigen::Vector2d::Zero();  // of x and y, where nothing touches it [m/s²]
};

struct Scene {
  Eigen::Vector3d p_WE, v_WE;  // the end effector [m, m/s]
  int ball_count;
  std::array<Ball, kMaxBalls> balls;  // the first ball_count of them
};

}  // namespace c3rt::planner
