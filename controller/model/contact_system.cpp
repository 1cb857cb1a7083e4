#include "controller/model/contact_system.hpp"

namespace c3rt::model {
namespace {

/// v⁺ = V_x x + V_u u + V_d + V_lambda λ with the contacts left out.
void free_motion(const ContactSystem& system, double dt, LcsStorage& motion) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v();
  motion.V_x.resize(n_v, n_q + n_v);
  motion.V_x.leftCols(n_q) = dt * system.J_f_q;
  motion.V_x.rightCols(n_v) = Eigen::MatrixXd::Identity(n_v, n_v) + dt * system.J_f_v;
  motion.V_u = dt * system.J_f_u;
  motion.V_d = dt * system.d_v;
}

/// A, B, D, d of q⁺ = q + Δt N_q v⁺ and v⁺ = V_x x + V_u u + V_lambda λ + V_d; E … c left alone.
void implicit_dynamics(const ContactSystem& system, double dt, LcsStorage& motion, lcs::Lcs& lcs) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_x = n_q + n_v;
  lcs.A.setZero(n_x, n_x);
  lcs.A.topLeftCorner(n_q, n_q).setIdentity();
  motion.to_A.resize(n_q, n_x);
  motion.to_A.noalias() = dt * system.N_q * motion.V_x;
  lcs.A.topRows(n_q) += motion.to_A;
  lcs.A.bottomRows(n_v) = motion.V_x;
  lcs.B.resize(n_x, system.n_u());
  lcs.B.topRows(n_q).noalias() = dt * system.N_q * motion.V_u;
  lcs.B.bottomRows(n_v) = motion.V_u;
  lcs.D.resize(n_x, motion.V_lambda.cols());
  lcs.D.topRows(n_q).noalias() = dt * system.N_q * motion.V_lambda;
  lcs.D.bottomRows(n_v) = motion.V_lambda;
  lcs.d.resize(n_x);
  lcs.d.head(n_q).noalias() = dt * system.N_q * motion.V_d;
  lcs.d.tail(n_v) = motion.V_d;
}

/// (n_c × n_c n_e): sums over the edges of each contact.
void edge_sums(Eigen::Index n_c, Eigen::Index n_e, Eigen::MatrixXd& E_t) {
  E_t.setZero(n_c, n_c * n_e);
  for (Eigen::Index contact = 0; contact < n_c; ++contact)
    E_t.row(contact).segment(contact * n_e, n_e).setOnes();
}

}  // namespace

void stewart_trinkle(const ContactSystem& system, double dt, LcsStorage& storage, lcs::Lcs& lcs) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_u = system.n_u();
  const Eigen::Index n_c = system.n_c(), n_e = system.n_e();
  const Eigen::Index n_x = n_q + n_v, n_t = n_c * n_e, n_lambda = 2 * n_c + n_t;
  free_motion(system, dt, storage);
  auto& [V_x, V_u, V_lambda, E_t, J_c, J_n_q, to_A, to_E, to_F, mu, V_d, phi_q] = storage;
  V_lambda.setZero(n_v, n_lambda);
  V_lambda.middleCols(n_c, n_c).noalias() = dt * system.M_inverse * system.J_n.transpose();
  V_lambda.rightCols(n_t).noalias() = dt * system.M_inverse * system.J_t.transpose();
  edge_sums(n_c, n_e, E_t);

  implicit_dynamics(system, dt, storage, lcs);
  lcs.E.setZero(n_lambda, n_x);
  lcs.F.setZero(n_lambda, n_lambda);
  lcs.H.setZero(n_lambda, n_u);
  lcs.c.setZero(n_lambda);

  lcs.F.block(0, n_c, n_c, n_c) = system.mu.asDiagonal();
  lcs.F.block(0, 2 * n_c, n_c, n_t) = -E_t;

  J_n_q.resize(n_c, n_q);
  J_n_q.noalias() = system.J_n * system.N_q_plus;
  lcs.E.middleRows(n_c, n_c).noalias() = dt * system.J_n * V_x;
  lcs.E.block(n_c, 0, n_c, n_q) += J_n_q;
  lcs.F.middleRows(n_c, n_c).noalias() = dt * system.J_n * V_lambda;
  lcs.H.middleRows(n_c, n_c).noalias() = dt * system.J_n * V_u;
  lcs.c.segment(n_c, n_c).noalias() = system.phi - J_n_q * system.q;
  lcs.c.segment(n_c, n_c).noalias() += dt * system.J_n * V_d;

  lcs.E.bottomRows(n_t).noalias() = system.J_t * V_x;
  lcs.F.bottomRows(n_t).noalias() = system.J_t * V_lambda;
  lcs.F.bottomLeftCorner(n_t, n_c) += E_t.transpose();
  lcs.H.bottomRows(n_t).noalias() = system.J_t * V_u;
  lcs.c.tail(n_t).noalias() = system.J_t * V_d;
}

void anitescu(const ContactSystem& system, double dt, LcsStorage& storage, lcs::Lcs& lcs) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_c = system.n_c(), n_e = system.n_e();
  const Eigen::Index n_lambda = n_c * (n_e > 0 ? n_e : 1);
  free_motion(system, dt, storage);
  auto& [V_x, V_u, V_lambda, E_t, J_c, J_n_q, to_A, to_E, to_F, mu, V_d, phi_q] = storage;
  edge_sums(n_c, n_e > 0 ? n_e : 1, E_t);
  J_c.resize(n_lambda, n_v);
  J_c.noalias() = E_t.transpose() * system.J_n;
  if (n_e > 0) {
    mu.resize(n_lambda);
    mu.noalias() = E_t.transpose() * system.mu;
    J_c += mu.asDiagonal() * system.J_t;
  }
  V_lambda.resize(n_v, n_lambda);
  V_lambda.noalias() = system.M_inverse * J_c.transpose();

  implicit_dynamics(system, dt, storage, lcs);
  J_n_q.resize(n_c, n_q);
  J_n_q.noalias() = system.J_n * system.N_q_plus;
  lcs.E.resize(n_lambda, n_q + n_v);
  lcs.E.noalias() = J_c * V_x;
  to_E.resize(n_lambda, n_q);
  to_E.noalias() = E_t.transpose() * J_n_q;
  lcs.E.leftCols(n_q) += to_E / dt;
  to_F.resize(n_lambda, n_lambda);
  to_F.noalias() = J_c * V_lambda;
  // what rounding leaves of the asymmetry would reach the convex projection
  lcs.F = 0.5 * (to_F + to_F.transpose());
  lcs.H.resize(n_lambda, system.n_u());
  lcs.H.noalias() = J_c * V_u;
  phi_q.resize(n_c);
  phi_q.noalias() = system.phi - J_n_q * system.q;
  lcs.c.resize(n_lambda);
  lcs.c.noalias() = E_t.transpose() * phi_q;
  lcs.c /= dt;
  lcs.c.noalias() += J_c * V_d;
}

lcs::Lcs stewart_trinkle(const ContactSystem& system, double dt) {
  LcsStorage storage;
  lcs::Lcs lcs;
  stewart_trinkle(system, dt, storage, lcs);
  return lcs;
}

lcs::Lcs anitescu(const ContactSystem& system, double dt) {
  LcsStorage storage;
  lcs::Lcs lcs;
  anitescu(system, dt, storage, lcs);
  return lcs;
}

lcs::Lcs spring_contacts(const ContactSystem& system, const Eigen::VectorXd& stiffness, double dt) {
  const Eigen::Index n_q = system.n_q(), n_v = system.n_v(), n_u = system.n_u(), n_c = system.n_c();
  const Eigen::Index n_x = n_q + n_v;
  LcsStorage motion;
  free_motion(system, dt, motion);
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
