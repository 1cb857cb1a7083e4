#include "controller/model/contact_system.hpp"

namespace c3rt::model {
namespace {

/// v⁺ = V_x x + V_u u + V_d + V_lambda λ with the contacts left out.
struct FreeMotion {
  Eigen::MatrixXd V_x, V_u;
  Eigen::VectorXd V_d;
};

FreeMotion free_motion(const ContactSystem& system, double dt) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v();
  FreeMotion motion;
  motion.V_x.resize(n_v, n_q + n_v);
  motion.V_x.leftCols(n_q) = dt * system.J_f_q;
  motion.V_x.rightCols(n_v) = Eigen::MatrixXd::Identity(n_v, n_v) + dt * system.J_f_v;
  motion.V_u = dt * system.J_f_u;
  motion.V_d = dt * system.d_v;
  return motion;
}

/// A, B, D, d of q⁺ = q + Δt N_q v⁺ and v⁺ = V_x x + V_u u + V_lambda λ + V_d; E … c left empty.
lcs::Lcs implicit_dynamics(const ContactSystem& system, double dt, const FreeMotion& motion,
                           const Eigen::MatrixXd& V_lambda) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_x = n_q + n_v;
  lcs::Lcs lcs;
  lcs.A = Eigen::MatrixXd::Zero(n_x, n_x);
  lcs.A.topLeftCorner(n_q, n_q).setIdentity();
  lcs.A.topRows(n_q) += dt * system.N_q * motion.V_x;
  lcs.A.bottomRows(n_v) = motion.V_x;
  lcs.B.resize(n_x, system.n_u());
  lcs.B << dt * system.N_q * motion.V_u, motion.V_u;
  lcs.D.resize(n_x, V_lambda.cols());
  lcs.D << dt * system.N_q * V_lambda, V_lambda;
  lcs.d.resize(n_x);
  lcs.d << dt * system.N_q * motion.V_d, motion.V_d;
  return lcs;
}

/// (n_c × n_c n_e): sums over the edges of each contact.
Eigen::MatrixXd edge_sums(Eigen::Index n_c, Eigen::Index n_e) {
  Eigen::MatrixXd E_t = Eigen::MatrixXd::Zero(n_c, n_c * n_e);
  for (Eigen::Index contact = 0; contact < n_c; ++contact)
    E_t.row(contact).segment(contact * n_e, n_e).setOnes();
  return E_t;
}

}  // namespace

lcs::Lcs stewart_trinkle(const ContactSystem& system, double dt) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_u = system.n_u();
  const Eigen::Index n_c = system.n_c(), n_e = system.n_e();
  const Eigen::Index n_x = n_q + n_v, n_t = n_c * n_e, n_lambda = 2 * n_c + n_t;
  const FreeMotion motion = free_motion(system, dt);
  const auto& [V_x, V_u, V_d] = motion;
  Eigen::MatrixXd V_lambda = Eigen::MatrixXd::Zero(n_v, n_lambda);
  V_lambda.middleCols(n_c, n_c) = dt * system.M_inverse * system.J_n.transpose();
  V_lambda.rightCols(n_t) = dt * system.M_inverse * system.J_t.transpose();
  const Eigen::MatrixXd E_t = edge_sums(n_c, n_e);

  lcs::Lcs lcs = implicit_dynamics(system, dt, motion, V_lambda);
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

lcs::Lcs anitescu(const ContactSystem& system, double dt) {
  const Eigen::Index n_q = system.n_q(), n_c = system.n_c(), n_e = system.n_e();
  const FreeMotion motion = free_motion(system, dt);
  const Eigen::MatrixXd E_t = edge_sums(n_c, n_e > 0 ? n_e : 1);
  Eigen::MatrixXd J_c = E_t.transpose() * system.J_n;
  if (n_e > 0) J_c += (E_t.transpose() * system.mu).asDiagonal() * system.J_t;
  const Eigen::MatrixXd V_lambda = system.M_inverse * J_c.transpose();

  lcs::Lcs lcs = implicit_dynamics(system, dt, motion, V_lambda);
  const Eigen::MatrixXd J_n_q = system.J_n * system.N_q_plus;
  lcs.E = J_c * motion.V_x;
  lcs.E.leftCols(n_q) += E_t.transpose() * J_n_q / dt;
  lcs.F = J_c * V_lambda;
  // what rounding leaves of the asymmetry would reach the convex projection
  lcs.F = 0.5 * (lcs.F + lcs.F.transpose()).eval();
  lcs.H = J_c * motion.V_u;
  lcs.c = E_t.transpose() * (system.phi - J_n_q * system.q) / dt + J_c * motion.V_d;
  return lcs;
}

lcs::Lcs spring_contacts(const ContactSystem& system, const Eigen::VectorXd& stiffness, double dt) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_u = system.n_u(), n_c = system.n_c();
  const Eigen::Index n_x = n_q + n_v;
  const FreeMotion motion = free_motion(system, dt);
  lcs::Lcs lcs;
  lcs.A = Eigen::MatrixXd::Zero(n_x, n_x);
  lcs.A.topLeftCorner(n_q, n_q).setIdentity();
  lcs.A.topRightCorner(n_q, n_v) = dt * system.N_q;
  lcs.A.bottomRows(n_v) = motion.V_x;
  lcs.B = Eigen::MatrixXd::Zero(n_x, n_u);
  lcs.B.bottomRows(n_v) = motion.V_u;
  lcs.D = Eigen::MatrixXd::Zero(n_x, n_c);
  lcs.D.bottomRows(n_v) = dt * system.M_inverse * system.J_n.transpose();
  lcs.d = Eigen::VectorXd::Zero(n_x);
  lcs.d.tail(n_v) = motion.V_d;

  const Eigen::MatrixXd J_n_q = system.J_n * system.N_q_plus;
  lcs.E = Eigen::MatrixXd::Zero(n_c, n_x);
  lcs.E.leftCols(n_q) = J_n_q;
  lcs.F = stiffness.cwiseInverse().asDiagonal();
  lcs.H = Eigen::MatrixXd::Zero(n_c, n_u);
  lcs.c = system.phi - J_n_q * system.q;
  return lcs;
}

}  // namespace c3rt::model
