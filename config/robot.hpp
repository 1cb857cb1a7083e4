#pragma once
// The robot's description (config/robots), read by the arm's model, the impedance controller and
// the plant.
#include <optional>
#include <string>

#include "config/section.hpp"

namespace c3rt::config {

using Vector7d = Eigen::Matrix<double, 7, 1>;

struct Robot {
  std::string urdf;    // absolute, or below the folder of models that the set-up installed
  std::string flange;  // link of the URDF that carries the end effector
  // that the robot itself enforces
  Vector7d q_min, q_max;  // [rad]
  Vector7d dq_max;        // [rad/s]
  Vector7d tau_max;       // [N m]
  double tau_rate_max;    // [N m/s]
  /// From which torque or force on a contact is told, and from which on a collision stops the
  /// robot; forces along and torques about the end effector's axes [N m, N].
  struct Thresholds {
    Vector7d contact_torque, collision_torque;
    Eigen::Matrix<double, 6, 1> contact_force, collision_force;
  };
  /// What else it stops for; nothing where its description does not say so.
  struct Safety {
    double velocity_max;          // of the end effector [m/s]
    double angular_velocity_max;  // [rad/s]
    double power_max;             // mechanical, of all joints [W]
    Vector7d tau_sensor_max;      // gravity included [N m]
    double clearance_min;         // between forearm or wrist and base or shoulder [m]
    Thresholds nominal, acceleration;
    /// Of what motion generators command; none: no limit.
    struct Motion {
      Vector7d joint_acceleration, joint_jerk;    // [rad/s^2, rad/s^3]
      double acceleration, angular_acceleration;  // of the end effector [m/s^2, rad/s^2]
      double jerk, angular_jerk;                  // [m/s^3, rad/s^3]
    };
    std::optional<Motion> motion;
  };
  std::optional<Safety> safety;
  /// Bolted to the flange, everything along its z.
  struct EndEffector {
    double mass;            // [kg]
    double center_of_mass;  // [m]
    double inertia_xx;      // about the centre of mass; also yy [kg m^2]
    double inertia_zz;      // [kg m^2]
    double sphere_center;   // [m]
    double sphere_radius;   // [m]
  } end_effector;
};

/// Of a whole scenario; the Panda's where it names none. @throws ConfigError
Robot load_robot(Section& root);

/// One of config/robots, without a scenario. @throws ConfigError
Robot load_robot(const std::string& name);

}  // namespace c3rt::config
