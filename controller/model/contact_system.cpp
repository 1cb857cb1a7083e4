#include "controller/model/contact_system.hpp"

namespace c3rt::model {

lcs::Lcs stewart_trinkle(const ContactSystem& system, double dt) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_u = system.n_u();
  const Eigen::Index n_c = system.n_c(), n_e = system.n_e();
  const Eigen::Index n_x = n_q + n_v, n_t = n_c * n_e, n_lambda = 2 * n_c + n_t;

  // v⁺ = V_x x + V_u u + V_lambda λ + V_d
  Eigen::MatrixXd V_x(n_v, n_x);
  V_x.leftCols(n_q) = dt * system.J_f_q;
  V_x.rightCols(n_v) = Eigen::MatrixXd::Identity(n_v, n_v) + dt * system.J_f_v;
  const Eigen::MatrixXd V_u = dt * system.J_f_u;
  Eigen::MatrixXd V_lambda = Eigen::MatrixXd::Zero(n_v, n_lambda);
  V_lambda.middleCols(n_c, n_c) = dt * system.M_inverse * system.J_n.transpose();
  V_lambda.rightCols(n_t) = dt * system.M_inverse * system.J_t.transpose();
  const Eigen::VectorXd V_d = dt * system.d_v;

  lcs::Lcs lcs;
  lcs.A = Eigen::MatrixXd::Zero(n_x, n_x);
  lcs.A.topLeftCorner(n_q, n_q).setIdentity();
  lcs.A.topRows(n_q) += dt * system.N_q * V_x;
  lcs.A.bottomRows(n_v) = V_x;
  lcs.B.resize(n_x, n_u);
  lcs.B << dt * system.N_q * V_u, V_u;
  lcs.D.resize(n_x, n_lambda);
  lcs.D << dt * system.N_q * V_lambda, V_lambda;
  lcs.d.resize(n_x);
  lcs.d << dt * system.N_q * V_d, V_d;

  Eigen::MatrixXd E_t = Eigen::MatrixXd::Zero(n_c, n_t);
  for (Eigen::Index contact = 0; contact < n_c; ++contact)
    E_t.row(contact).segment(contact * n_e, n_e).setOnes();

  lcs.E = Eigen::MatrixXd::Zero(n_lambda, n_x);
  lcs.F = Eigen::MatrixXd::Zero(n_lambda, n_lambda);
  lcs.H = Eigen::MatrixXd::Zero(n_lambda, n_u);
  lcs.c = Eigen::VectorXd::Zero(n_lambda);

  lcs.F.block(0, n_c, n_c, n_c) = system.mu.asDiagonal();
  lcs.F.block(0, 2 * n_c, n_c, n_t) = -E_t;

  const Eigen::MatrixXd J_n_q = system.J_n * system.N_q_plus;
  lcs.E.middleRows(n_c, n_c) = dt * system.J_n * V_x;
  lcs.E.block(n_c, 0, n_c, n_q) += J_n_q;
  lcs.F.middleRows(n_c, n_c) = dt * system.J_n * V_lambda;
  lcs.H.middleRows(n_c, n_c) = dt * system.J_n * V_u;
  lcs.c.segment(n_c, n_c) = system.phi - J_n_q * system.q + dt * system.J_n * V_d;

  lcs.E.bottomRows(n_t) = system.J_t * V_x;
  lcs.F.bottomRows(n_t) = system.J_t * V_lambda;
  lcs.F.bottomLeftCorner(n_t, n_c) += E_t.transpose();
  lcs.H.bottomRows(n_t) = system.J_t * V_u;
  lcs.c.tail(n_t) = system.J_t * V_d;
  return lcs;
}

}  // namespace c3rt::model
