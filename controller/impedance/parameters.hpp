#pragma once
// What a scenario chooses about the impedance controller (section `impedance:`); read by
// load_parameters.
#include <string>

#include <Eigen/Core>

#include "controller/impedance/law.hpp"

namespace c3rt::impedance {

/// How the reference follows a plan of one knot.
enum class Reference {
  kHold,         // x_d and v_d as they come
  kInterpolate,  // moves with v_d so as to reach x_d at the knot's time, then rests there
};

struct Limits {
  double reference_speed;          // of the tracked position [m/s]
  double reference_angular_speed;  // of the tracked orientation [rad/s]
  // What a plan may ask of the arm. The reference leads the arm by no more than what the law
  // answers with these accelerations, however far away a plan is.
  double plan_speed;                 // v_d [m/s]
  double plan_acceleration;          // its change [m/s^2]
  double lead_acceleration;          // [m/s^2]
  double lead_angular_acceleration;  // [rad/s^2]
  double plan_force;                 // that is fed forward [N]
  Eigen::Vector3d workspace_min;     // box for the tracked position, in W [m]
  Eigen::Vector3d workspace_max;
  model::Vector7d tau_max;       // [N m]
  double tau_rate_max;           // [N m/s]
  model::Vector7d q_min, q_max;  // outside: stop [rad]
  model::Vector7d dq_max;        // outside: stop [rad/s]
  double state_timeout;          // an older robot state stops the arm for good [s]
  double plan_timeout;           // an older plan is not tracked, whatever its valid_until says [s]
  double stop_damping;           // of M dq when stopped [1/s]
};

struct Thread {
  int fifo_priority;  // SCHED_FIFO 1..99; 0: ordinary scheduling
  int cpu;            // that the servo thread runs on; -1: any
};

struct Parameters {
  double period;                // [s]
  bool recovers_alone = false;  // from a robot state that was missing, once it comes steadily again
  Reference reference;
  bool feed_forward;
  double feed_forward_threshold;  // forces below this are not fed forward [N]
  Gains gains;
  Limits limits;
  Thread thread;
  model::ArmDescription arm;
};

}  // namespace c3rt::impedance
