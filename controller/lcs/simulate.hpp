#pragma once

#include <vector>

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"
#include "controller/lcs/lemke.hpp"

namespace c3rt::lcs {

/// How far a simulation of N steps came. It stops at the first step whose LCP has no answer.
struct SimulateReport {
  int steps;        // completed; the step of this index is the one that failed, unless ok()
  LcpReport lcp;    // of the last step tried
  double residual;  // largest LcpReport::residual of the completed steps
  int regularised;  // completed steps whose LCP was solved by way of F + ε I
  bool ok() const noexcept { return lcp.status == LcpStatus::kSolved; }
};

/// A simulation in which only the steps that succeeded stand.
struct Simulation {
  Eigen::MatrixXd x;       // x_0 … (n_x × steps + 1)
  Eigen::MatrixXd lambda;  // (n_lambda × steps)
  SimulateReport report;
};

/// N = u.cols() steps of the system from x_0 with the inputs u (n_u × N), each LCP solved by
/// Lemke's method.
/// @throws std::invalid_argument as `check`, and naming x_0 or u if its shape is wrong or if it is
/// not finite
[[nodiscard]] Simulation simulate(const Lcs& lcs, const Eigen::VectorXd& x_0,
                                  const Eigen::MatrixXd& u);

/// The same for a time-varying system: step k uses `lcs[k]`.
/// @throws std::invalid_argument also if there are not N systems or they differ in size
[[nodiscard]] Simulation simulate(const std::vector<Lcs>& lcs, const Eigen::VectorXd& x_0,
                                  const Eigen::MatrixXd& u);

/// `simulate` into the caller's storage: x (n_x × N + 1), lambda (n_lambda × N), columns after
/// the last completed step are left as they are. The blocks of `lcs` have passed `check`, `lemke`
/// has size n_lambda, x_0 and u have the sizes of `lcs`.
/// RT: no heap, no lock, no throw.
[[nodiscard]] SimulateReport simulate(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x_0,
                                      const Eigen::Ref<const Eigen::MatrixXd>& u, Lemke& lemke,
                                      Eigen::Ref<Eigen::MatrixXd> x,
                                      Eigen::Ref<Eigen::MatrixXd> lambda) noexcept;

/// The same for a time-varying system of at least N steps: step k uses `lcs[k]`.
/// RT: no heap, no lock, no throw.
[[nodiscard]] SimulateReport simulate(const std::vector<Lcs>& lcs,
                                      const Eigen::Ref<const Eigen::VectorXd>& x_0,
                                      const Eigen::Ref<const Eigen::MatrixXd>& u, Lemke& lemke,
                                      Eigen::Ref<Eigen::MatrixXd> x,
                                      Eigen::Ref<Eigen::MatrixXd> lambda) noexcept;

}  // namespace c3rt::lcs
