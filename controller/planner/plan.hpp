#pragma once
// What the planner answers in one period.
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "controller/planner/activity.hpp"

namespace c3rt::planner {

enum class PlanStatus { kOk, kTruncated, kFallback };

/// A place of the end effector that a strategy weighed in this period.
struct WeighedPlace {
  Eigen::Vector3d p_WE;  // [m]
  int body;              // beside which it is
  bool known;            // false: the plan from there has no answer, or leads out of reach
  double cost, still;    // of the objects where the plan from there is tried, and where nothing is
};

struct Plan {
  PlanStatus status;
  Mode mode;
  const char* phase;           // a word for it; in kTask the strategy's own
  Eigen::Vector3d p_WE, v_WE;  // x_d of the end effector
  Eigen::Quaterniond q_WE;
  // λ_d as the contacts' force on the end effector, and the strategy's bias, in W [N]
  Eigen::Vector3d force_E;
  int body;                     // that the strategy works on
  Eigen::Vector3d body_target;  // its x_d^b
  double delta_t_c;             // [s]
  Eigen::Vector3d u_c3;         // [N]
  Eigen::VectorXd lambda_d;     // of the step over Δt_c, with every contact [N]
  Eigen::MatrixXd x;            // (n_x × N) predicted
  Eigen::MatrixXd lambda;       // of the planning system (n_lambda × N) [N]
  Eigen::MatrixXd u;            // (n_u × N) [N]
  int admm_iterations;
  Eigen::VectorXd primal_residual;  // (admm_iterations)
  double complementarity_violation;
  // of a strategy that compares places: those of this period, and where the end effector is to push
  // from
  std::vector<WeighedPlace> weighed;
  std::optional<Eigen::Vector3d> place;  // [m]
};

}  // namespace c3rt::planner
