#include "controller/lcs/simulate.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "controller/lcs/require.hpp"
#include "controller/lcs/step.hpp"

namespace c3rt::lcs {
namespace {

// `system(k)` gives the matrices of step k
template <typename System>
SimulateReport run(const System& system, const Eigen::Ref<const Eigen::VectorXd>& x_0,
                   const Eigen::Ref<const Eigen::MatrixXd>& u, Lemke& lemke,
                   Eigen::Ref<Eigen::MatrixXd> x, Eigen::Ref<Eigen::MatrixXd> lambda) noexcept {
  SimulateReport report{0, {LcpStatus::kSolved, 0, 0.0, 0.0}, 0.0, 0};
  x.col(0) = x_0;
  for (Eigen::Index k = 0; k < u.cols(); ++k) {
    report.lcp = step(system(k), x.col(k), u.col(k), lemke, x.col(k + 1), lambda.col(k)).lcp;
    if (!report.ok()) break;
    report.residual = std::max(report.residual, report.lcp.residual);
    if (report.lcp.epsilon > 0.0) ++report.regularised;
    ++report.steps;
  }
  return report;
}

// `lcs` is one system or a sequence of them, already checked
template <typename Systems>
Simulation run_checked(const Systems& lcs, const Sizes& sizes, const Eigen::VectorXd& x_0,
                       const Eigen::MatrixXd& u) {
  require("simulate: x_0", x_0, sizes.n_x, 1);
  require("simulate: u", u, sizes.n_u, u.cols());
  Simulation result;
  result.x.resize(sizes.n_x, u.cols() + 1);
  result.lambda.resize(sizes.n_lambda, u.cols());
  Lemke lemke(sizes.n_lambda);
  result.report = simulate(lcs, x_0, u, lemke, result.x, result.lambda);
  result.x.conservativeResize(Eigen::NoChange, result.report.steps + 1);
  result.lambda.conservativeResize(Eigen::NoChange, result.report.steps);
  return result;
}

}  // namespace

Simulation simulate(const Lcs& lcs, const Eigen::VectorXd& x_0, const Eigen::MatrixXd& u) {
  check(lcs);
  return run_checked(lcs, sizes(lcs), x_0, u);
}

Simulation simulate(const std::vector<Lcs>& lcs, const Eigen::VectorXd& x_0,
                    const Eigen::MatrixXd& u) {
  if (static_cast<Eigen::Index>(lcs.size()) != u.cols())
    throw std::invalid_argument("simulate: expected " + std::to_string(u.cols()) +
                                " systems, one for each input, got " + std::to_string(lcs.size()));
  const Sizes all = lcs.empty() ? Sizes{static_cast<int>(x_0.size()), 0, static_cast<int>(u.rows())}
                                : sizes(lcs.front());
  for (std::size_t k = 0; k < lcs.size(); ++k) {
    check(lcs[k]);
    const Sizes here = sizes(lcs[k]);
    if (here.n_x != all.n_x || here.n_lambda != all.n_lambda || here.n_u != all.n_u)
      throw std::invalid_argument("simulate: system " + std::to_string(k) +
                                  " differs in size from system 0");
  }
  return run_checked(lcs, all, x_0, u);
}

SimulateReport simulate(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x_0,
                        const Eigen::Ref<const Eigen::MatrixXd>& u, Lemke& lemke,
                        Eigen::Ref<Eigen::MatrixXd> x,
                        Eigen::Ref<Eigen::MatrixXd> lambda) noexcept {
  return run([&](Eigen::Index) -> const Lcs& { return lcs; }, x_0, u, lemke, x, lambda);
}

SimulateReport simulate(const std::vector<Lcs>& lcs, const Eigen::Ref<const Eigen::VectorXd>& x_0,
                        const Eigen::Ref<const Eigen::MatrixXd>& u, Lemke& lemke,
                        Eigen::Ref<Eigen::MatrixXd> x,
                        Eigen::Ref<Eigen::MatrixXd> lambda) noexcept {
  return run([&](Eigen::Index k) -> const Lcs& { return lcs[static_cast<std::size_t>(k)]; }, x_0, u,
             lemke, x, lambda);
}

}  // namespace c3rt::lcs
