#pragma once

#include <vector>

#include <Eigen/Core>

#include "controller/horizon/problem.hpp"

namespace c3rt::horizon {

/// The problem without its states:
///
///   minimise vᵀ H v + 2 gᵀ v + constant,   v = [u_0; λ_0; … u_{N−1}; λ_{N−1}]
///   with     s = J v + c ≥ 0, of pairs (i, n_pairs + i) one zero, of equalities all zero
///
/// s = [λ; y; the one-sided constraints], y = E x + F λ + H u + c.
struct Condensed {
  Eigen::MatrixXd H;  // (n_v × n_v) positive semidefinite
  Eigen::VectorXd g;  // (n_v)
  double constant = 0.0;
  Eigen::MatrixXd J;            // (rows × n_v)
  Eigen::VectorXd c;            // (rows)
  int n_pairs = 0;              // N n_lambda; pair i = k n_lambda + j
  std::vector<int> equalities;  // rows
};

Condensed condense(const Problem& problem);

/// Simulates v.
Plan roll_out(const Problem& problem, const Eigen::VectorXd& v);

/// A condensed problem whose quadratic term is made definite around a centre v_c, as the least
/// distance from the origin that c3::NodeQp solves:
///
///   vᵀ H v + 2 gᵀ v + ε ‖v − v_c‖² = lowest + ‖f‖²,   s = (t + Cᵀ f)/scale
class LeastDistance {
 public:
  /// @param epsilon  ε relative to the largest diagonal entry of H
  LeastDistance(const Condensed& condensed, double epsilon);

  void centre(const Eigen::VectorXd& v_c);

  const Eigen::MatrixXd& C() const noexcept {
    return C_;
  }  // (n_v × rows), columns of length 1 or 0
  const Eigen::VectorXd& t() const noexcept { return t_; }  // (rows)
  double lowest() const noexcept { return lowest_; }        // with the problem's constant
  Eigen::VectorXd v(const Eigen::VectorXd& f) const;

 private:
  const Condensed* condensed_;
  double epsilon_;
  Eigen::MatrixXd L_;  // H + ε = L Lᵀ, lower triangle
  Eigen::MatrixXd C_;
  Eigen::VectorXd scale_, t_, v_free_;
  double lowest_ = 0.0;
};

}  // namespace c3rt::horizon
