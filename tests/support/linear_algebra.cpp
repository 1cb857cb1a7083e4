#include "tests/support/linear_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace c3rt::support {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd solve_definite(const Matrix& A, const Matrix& B) {
  return Eigen::LLT<MatrixXd>(A).solve(B);
}

MatrixXd inverse_root(const Matrix& A) {
  return Eigen::LLT<MatrixXd>(A).matrixL().solve(MatrixXd::Identity(A.rows(), A.cols()));
}

bool is_definite(const Matrix& A) { return Eigen::LLT<MatrixXd>(A).info() == Eigen::Success; }

std::optional<VectorXd> solve(const Matrix& A, const Matrix& b) {
  const Eigen::FullPivLU<MatrixXd> factors(A);
  if (factors.rank() < A.cols()) return std::nullopt;
  return factors.solve(b);
}

VectorXd least_squares(const Matrix& A, const Matrix& b) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A).solve(b);
}

MatrixXd inverse(const Matrix& A) { return Eigen::PartialPivLU<MatrixXd>(A).inverse(); }

VectorXd eigenvalues(const Matrix& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

VectorXd eigenvalues(const Matrix& A, const Matrix& B) {
  const MatrixXd L_inverse = inverse_root(B);
  return eigenvalues(L_inverse * A * L_inverse.transpose());
}

}  // namespace c3rt::support
