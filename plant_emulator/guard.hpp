#pragma once
// What the robot looks at in every cycle before it moves on: its limits, and what it touches. Pure
// functions.
#include <cmath>
#include <cstdint>

#include "plant_emulator/errors.hpp"
#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

/// What the robot measures and estimates of itself.
struct Measured {
  Vector7d q = Vector7d::Zero();           // [rad]
  Vector7d dq = Vector7d::Zero();          // [rad/s]
  Vector7d tau = Vector7d::Zero();         // applied, without gravity [N m]
  Vector7d tau_sensor = Vector7d::Zero();  // applied, with gravity [N m]
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero();
  Vector6d V_WE = Vector6d::Zero();  // linear, angular, in W [m/s, rad/s]
  double clearance = kNoLimit;       // between forearm or wrist and base or shoulder [m]
};

/// What acts on the arm from outside, as the robot estimates it: positive where the world pushes
/// the arm along the axis.
struct External {
  Vector7d tau = Vector7d::Zero();       // filtered; libfranka's tau_ext_hat_filtered [N m]
  Vector6d wrench_W = Vector6d::Zero();  // at E, axes of W; O_F_ext_hat_K with K in E [N, N m]
  Vector6d wrench_E = Vector6d::Zero();  // at E, axes of E; K_F_ext_hat_K [N, N m]
  bool accelerates = false;              // then the thresholds of acceleration hold
};

/// Bit i is joint i + 1, or x, y, z, roll, pitch, yaw.
struct Contacts {
  std::uint32_t joint = 0, cartesian = 0;                      // now
  std::uint32_t joint_collision = 0, cartesian_collision = 0;  // until recovery
};

/// Finds each entry whose size is above the limit's entry. RT: no heap, no lock, no throw.
template <typename Values, typename Limits>
void judge_sizes(Error error, const char* unit, const Values& values, const Limits& limits,
                 Findings& findings) noexcept {
  for (int i = 0; i < static_cast<int>(values.size()); ++i) {
    if (std::abs(values[i]) > limits[i]) findings.add({error, i + 1, values[i], limits[i], unit});
  }
}

/// Finds each entry that is out of its range. RT: no heap, no lock, no throw.
template <typename Values>
void judge_range(Error error, const char* unit, const Values& values, const Values& least,
                 const Values& most, Findings& findings) noexcept {
  for (int i = 0; i < static_cast<int>(values.size()); ++i) {
    const bool below = values[i] < least[i];
    if (below || values[i] > most[i])
      findings.add({error, i + 1, values[i], below ? least[i] : most[i], unit});
  }
}

/// Limits of joints, end effector, walls, power, sensors and the arm's own body. RT: no heap, no
/// lock, no throw.
void judge_limits(const Measured& measured, const Parameters& parameters,
                  Findings& findings) noexcept;

/// Contacts and collisions, by the thresholds of the phase. RT: no heap, no lock, no throw.
void judge_contacts(const External& external, const CollisionBehavior& behavior, Contacts& contacts,
                    Findings& findings) noexcept;

/// A commanded torque that would have to jump: libfranka's controller_torque_discontinuity. RT: no
/// heap, no lock, no throw.
void judge_torque_step(const Vector7d& before, const Vector7d& command, double rate_max,
                       double cycle, Findings& findings) noexcept;

/// Distance between the segments a..b and c..d [m]. RT: no heap, no lock, no throw.
double segment_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& c, const Eigen::Vector3d& d) noexcept;

/// Estimates what acts from outside by the model: M(q) q̈ + C(q, q̇) q̇ + D q̇ − τ with the change of
/// velocity over a cycle as q̈, through a first-order low-pass. RT: no heap, no lock, no throw.
class ExternalEstimator {
 public:
  /// @param residual of the equation above, unfiltered [N m]
  /// @param acceleration [rad/s²]
  /// @param J_WE of the end effector, linear rows first
  const External& step(const Vector7d& residual, const Vector7d& acceleration,
                       const Eigen::Matrix<double, 6, kJoints>& J_WE,
                       const Eigen::Quaterniond& q_WE, double cycle) noexcept;
  const External& external() const noexcept { return external_; }
  void clear() noexcept;

 private:
  External external_;
  Vector7d acceleration_ = Vector7d::Zero();  // filtered [rad/s²]
};

}  // namespace c3rt::plant
