#pragma once

#include <optional>

#include <Eigen/Core>

namespace c3rt::lcs {

/// One step of a discrete-time linear complementarity system [C3, eq. (1)]:
///
///   x⁺ = A x + B u + D λ + d
///   0 ≤ λ ⊥ E x + F λ + H u + c ≥ 0
///
/// Symbols here and in c3/: x state, u input, λ (lambda) complementarity variables, y = E x + F λ +
/// H u + c their gap. A time-varying system is a vector of these.
struct Lcs {
  Eigen::MatrixXd A;  // (n_x × n_x)
  Eigen::MatrixXd B;  // (n_x × n_u)
  Eigen::MatrixXd D;  // (n_x × n_lambda)
  Eigen::VectorXd d;  // (n_x)
  Eigen::MatrixXd E;  // (n_lambda × n_x)
  Eigen::MatrixXd F;  // (n_lambda × n_lambda)
  Eigen::MatrixXd H;  // (n_lambda × n_u)
  Eigen::VectorXd c;  // (n_lambda)
};

struct Sizes {
  int n_x, n_lambda, n_u;
};

/// The sizes that A, F and B claim; `check` says whether the other blocks agree.
Sizes sizes(const Lcs& lcs);

/// Throws std::invalid_argument naming the first block whose shape is wrong or that is not finite:
/// "Lcs.E: expected 1 x 2, got 1 x 3".
void check(const Lcs& lcs);

/// Ratio that makes the columns of D comparable to those of A: ‖A‖²_F / ‖D‖²_F.
/// @throws std::invalid_argument if A or D is zero or not finite
double force_scale(const Lcs& lcs);
/// The same; none if A or D is zero or not finite. RT.
std::optional<double> find_force_scale(const Lcs& lcs) noexcept;

/// Expresses λ in units of `s`: afterwards the λ of the system is the true one divided by s, and x⁺
/// is what it was. D ← s D; E, H, c ← E/s, H/s, c/s; F stays.
/// @throws std::invalid_argument unless s is finite and positive
void scale_forces(Lcs& lcs, double s);

}  // namespace c3rt::lcs
