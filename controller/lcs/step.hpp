#pragma once

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"
#include "controller/lcs/lemke.hpp"

namespace c3rt::lcs {

struct StepReport {
  LcpReport lcp;
  [[nodiscard]] bool ok() const noexcept { return lcp.status == LcpStatus::kSolved; }
};

/// The λ of LCP(E x + H u + c, F), by Lemke's method; zero unless the report says kSolved. `lemke`
/// has size n_lambda; the blocks of `lcs` have passed `check`. RT: no heap, no lock, no throw.
[[nodiscard]] LcpReport solve_lcp(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x,
                                  const Eigen::Ref<const Eigen::VectorXd>& u, Lemke& lemke,
                                  Eigen::Ref<Eigen::VectorXd> lambda) noexcept;

/// The same where H = 0, so that u does not matter. RT: no heap, no lock, no throw.
[[nodiscard]] LcpReport solve_lcp(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x,
                                  Lemke& lemke, Eigen::Ref<Eigen::VectorXd> lambda) noexcept;

/// One step of the system, its LCP solved by Lemke's method. Unless report.ok(), x_next and lambda
/// are not to be used (lambda is zero, x_next the step without forces). RT: no heap, no lock, no
/// throw.
[[nodiscard]] StepReport step(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x,
                              const Eigen::Ref<const Eigen::VectorXd>& u, Lemke& lemke,
                              Eigen::Ref<Eigen::VectorXd> x_next,
                              Eigen::Ref<Eigen::VectorXd> lambda) noexcept;

}  // namespace c3rt::lcs
