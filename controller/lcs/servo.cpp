#include "controller/lcs/servo.hpp"

#include <Eigen/LU>

namespace c3rt::lcs {

void close_loop(const Lcs& lcs, const Eigen::MatrixXd& K, Lcs& closed, Eigen::MatrixXd& G) {
  const Eigen::Index n_u = K.rows();
  const Eigen::MatrixXd loop = Eigen::MatrixXd::Identity(n_u, n_u) + K * lcs.B;
  G = loop.partialPivLu().solve(K);
  const Eigen::MatrixXd GA = G * lcs.A, GD = G * lcs.D;
  const Eigen::VectorXd Gd = G * lcs.d;
  closed = lcs;
  closed.A.noalias() -= lcs.B * GA;
  closed.D.noalias() -= lcs.B * GD;
  closed.d.noalias() -= lcs.B * Gd;
  closed.E.noalias() -= lcs.H * GA;
  closed.F.noalias() -= lcs.H * GD;
  closed.c.noalias() -= lcs.H * Gd;
}

}  // namespace c3rt::lcs
