#pragma once

#include <Eigen/Core>

#include "controller/c3/problem.hpp"

namespace c3rt::horizon {

/// The whole contact-implicit problem at once [C3, eq. (15)], what Algorithm 1 only approximates:
///
///   minimise Σ_{k<N} (x_k−x_d,k)ᵀ Q_k (·) + u_kᵀ R_k u_k + (x_N−x_d,N)ᵀ Q_N (·)
///   over     u_0, λ_0, … u_{N−1}, λ_{N−1}, with x_0 given and
///            x_{k+1} = A x_k + B u_k + D λ_k + d,  0 ≤ λ_k ⊥ E x_k + F λ_k + H u_k + c ≥ 0
///
/// and the constraints of c3::Constraints. What is pointed to outlives the problem. Of the costs
/// Q, R, Q_N count.
struct Problem {
  c3::Sizes sizes;
  c3::Horizon systems;
  const c3::Costs* costs;
  const c3::Constraints* constraints;
  Eigen::MatrixXd x_desired;  // (n_x × N+1)
  Eigen::VectorXd x0;         // (n_x)
};

/// A trajectory.
struct Plan {
  Eigen::MatrixXd x;                       // (n_x × N+1)
  Eigen::MatrixXd lambda;                  // (n_lambda × N)
  Eigen::MatrixXd u;                       // (n_u × N)
  double objective = 0.0;                  // with the constant term of x_0
  double complementarity_violation = 0.0;  // max |min(λ, E x + F λ + H u + c)|
};

/// x_{k+1} of x_k, u_k and λ_k.
Eigen::VectorXd next_state(const Problem& problem, const Plan& plan, int k);

/// Sets objective and violation of the plan's x, λ and u.
void evaluate(const Problem& problem, Plan& plan);

/// Simulates the system open loop and evaluates the result. Does not look at the constraints.
Plan roll_out(const Problem& problem, const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& u);

/// How far the plan is from being one: the largest violation of the dynamics, of complementarity
/// and of the constraints, each in relation to the terms that its row adds up.
double residual(const Problem& problem, const Plan& plan);

/// A residual up to which a plan meets the problem.
constexpr double kMet = 1e-9;

}  // namespace c3rt::horizon
