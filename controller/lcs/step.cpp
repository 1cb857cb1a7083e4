#include "controller/lcs/step.hpp"

#include <cmath>

namespace c3rt::lcs {
namespace {

/// What block v is added up from, to `terms`.
void add_terms(const Eigen::MatrixXd& block, const Eigen::Ref<const Eigen::VectorXd>& v,
               Eigen::VectorXd& terms) noexcept {
  for (Eigen::Index j = 0; j < block.cols(); ++j) {
    const double size = std::abs(v[j]);
    if (size > 0.0) terms += size * block.col(j).cwiseAbs();
  }
}

/// Nothing touches with forces of 0: no answer of it needs a test by its terms.
bool is_open(const Eigen::VectorXd& q) noexcept { return q.size() == 0 || q.minCoeff() >= 0.0; }

}  // namespace

LcpReport solve_lcp(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x, Lemke& lemke,
                    Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  lemke.q() = lcs.c;
  lemke.q().noalias() += lcs.E * x;
  if (is_open(lemke.q())) return lemke.solve(lcs.F, lemke.q(), lemke.q(), lambda);
  lemke.terms() = lcs.c.cwiseAbs();
  add_terms(lcs.E, x, lemke.terms());
  return lemke.solve(lcs.F, lemke.q(), lemke.terms(), lambda);
}

LcpReport solve_lcp(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x,
                    const Eigen::Ref<const Eigen::VectorXd>& u, Lemke& lemke,
                    Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  lemke.q() = lcs.c;
  lemke.q().noalias() += lcs.E * x;
  lemke.q().noalias() += lcs.H * u;
  if (is_open(lemke.q())) return lemke.solve(lcs.F, lemke.q(), lemke.q(), lambda);
  lemke.terms() = lcs.c.cwiseAbs();
  add_terms(lcs.E, x, lemke.terms());
  add_terms(lcs.H, u, lemke.terms());
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
