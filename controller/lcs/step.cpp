#include "controller/lcs/step.hpp"

namespace c3rt::lcs {

StepReport step(const Lcs& lcs, const Eigen::Ref<const Eigen::VectorXd>& x,
                const Eigen::Ref<const Eigen::VectorXd>& u, Lemke& lemke,
                Eigen::Ref<Eigen::VectorXd> x_next, Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  Eigen::VectorXd& q = lemke.q();
  q = lcs.c;
  q.noalias() += lcs.E * x;
  q.noalias() += lcs.H * u;
  const LcpReport report = lemke.solve_regularised(lcs.F, q, lambda);
  x_next = lcs.d;
  x_next.noalias() += lcs.A * x;
  x_next.noalias() += lcs.B * u;
  x_next.noalias() += lcs.D * lambda;
  return {report};
}

}  // namespace c3rt::lcs
