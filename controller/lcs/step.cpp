#include "controller/lcs/step.hpp"

#include <cmath>

namespace c3rt::lcs {
namespace {

/// q += block v, and what that is added up from to terms.
void add(const Eigen::MatrixXd& block, const Eigen::Ref<const Eigen::VectorXd>& v,
         Lemke& lemke) noexcept {
  lemke.q().noalias() += block * v;
  for (Eigen::Index j = 0; j < block.cols(); ++j) {
    const double size = std::abs(v[j]);
    if (size > 0.0) lemke.terms() += size * block.col(j).cwiseAbs();
  }
}

}  // namespace

LcpReport solve_lcp(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x, Lemke& lemke,
                    Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  lemke.q() = lcs.c;
  lemke.terms() = lcs.c.cwiseAbs();
  add(lcs.E, x, lemke);
  return lemke.solve(lcs.F, lemke.q(), lemke.terms(), lambda);
}

LcpReport solve_lcp(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x,
                    const Eigen::Ref<const Eigen::VectorXd>& u, Lemke& lemke,
                    Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  lemke.q() = lcs.c;
  lemke.terms() = lcs.c.cwiseAbs();
  add(lcs.E, x, lemke);
  add(lcs.H, u, lemke);
  return lemke.solve(lcs.F, lemke.q(), lemke.terms(), lambda);
}

StepReport step(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x,
                const Eigen::Ref<const Eigen::VectorXd>& u, Lemke& lemke,
                Eigen::Ref<Eigen::VectorXd> x_next, Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const LcpReport report = solve_lcp(lcs, x, u, lemke, lambda);
  x_next = lcs.d;
  x_next.noalias() += lcs.A * x;
  x_next.noalias() += lcs.B * u;
  x_next.noalias() += lcs.D * lambda;
  return {report};
}

}  // namespace c3rt::lcs
