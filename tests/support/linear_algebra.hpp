#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

/// Decompositions of Eigen's, compiled once: in a test's own source each costs the compiler
/// seconds, and again for every size of matrix.
namespace c3rt::support {

using Matrix = Eigen::Ref<const Eigen::MatrixXd>;

/// A⁻¹ B of a symmetric positive definite A, by Cholesky.
Eigen::MatrixXd solve_definite(const Matrix& A, const Matrix& B);

/// L⁻¹ of a symmetric positive definite A = L Lᵀ.
Eigen::MatrixXd inverse_root(const Matrix& A);

/// Whether Cholesky's factors of a symmetric A exist.
bool is_definite(const Matrix& A);

/// The one x with A x = b, by elimination with full pivoting; none if A's columns are dependent.
/// Where A has more rows than columns, whether A x = b is for the caller to see.
std::optional<Eigen::VectorXd> solve(const Matrix& A, const Matrix& b);

/// The smallest x of those with the smallest ‖A x − b‖.
Eigen::VectorXd least_squares(const Matrix& A, const Matrix& b);

Eigen::MatrixXd inverse(const Matrix& A);

/// Of a symmetric A, the smallest first.
Eigen::VectorXd eigenvalues(const Matrix& A);

/// The λ of A v = λ B v, the smallest first; A symmetric, B symmetric positive definite.
Eigen::VectorXd eigenvalues(const Matrix& A, const Matrix& B);

/// The shortest turn of one unit vector into another that is not its opposite: (1 + cos θ, sin θ)
/// is twice cos θ/2 times (cos θ/2, sin θ/2).
inline Eigen::Quaterniond turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d axis = from.cross(to);
  return Eigen::Quaterniond(1.0 + from.dot(to), axis.x(), axis.y(), axis.z()).normalized();
}

}  // namespace c3rt::support
