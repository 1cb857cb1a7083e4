#include "controller/lcs/riccati.hpp"

#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace c3rt::lcs {
namespace {

// each iteration doubles the horizon that P has seen: 2⁵⁰ steps are enough for any sampling rate
constexpr int kIterations = 50;
constexpr double kConverged = 1e-14;  // change of P beside P
constexpr double kResidual = 1e-9;    // of the equation beside P

double residual(const Eigen::MatrixXd& P, const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R) {
  const Eigen::MatrixXd S = R + B.transpose() * P * B;
  const Eigen::MatrixXd K = S.llt().solve(B.transpose() * P * A);
  return (Q + A.transpose() * P * (A - B * K) - P).norm() / P.norm();
}

}  // namespace

Eigen::MatrixXd riccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                        const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R) {
  const Eigen::Index n_x = A.rows(), n_u = B.cols();
  if (A.cols() != n_x || B.rows() != n_x || Q.rows() != n_x || Q.cols() != n_x || R.rows() != n_u ||
      R.cols() != n_u)
    throw std::invalid_argument("riccati: A (n x n), B (n x m), Q (n x n), R (m x m) disagree");
  const Eigen::LLT<Eigen::MatrixXd> R_factor(R);
  if (R_factor.info() != Eigen::Success)
    throw std::invalid_argument("riccati: R: expected a positive definite matrix");

  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(n_x, n_x);
  Eigen::MatrixXd transition = A, gramian = B * R_factor.solve(B.transpose()), P = Q;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::PartialPivLU<Eigen::MatrixXd> W(I + gramian * P);
    const Eigen::MatrixXd W_transition = W.solve(transition);
    const Eigen::MatrixXd change = transition.transpose() * P * W_transition;
    gramian += transition * W.solve(gramian) * transition.transpose();
    gramian = 0.5 * (gramian + gramian.transpose()).eval();
    transition = (transition * W_transition).eval();
    P += 0.5 * (change + change.transpose());
    if (!P.allFinite()) break;
    if (change.norm() > kConverged * P.norm()) continue;
    if (P.isZero(0.0) || residual(P, A, B, Q, R) < kResidual) return P;
    break;
  }
  throw std::runtime_error("riccati: no stabilising solution found");
}

}  // namespace c3rt::lcs
