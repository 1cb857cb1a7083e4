#include "controller/c3/problem.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include "controller/c3/projection/registry.hpp"
#include "controller/qp/requirements.hpp"

namespace c3rt::c3 {
namespace {

using qp::name_of, qp::refuse, qp::require_weight, qp::require_weights, qp::text;

/// Without this the QP step has no unique minimiser.
void require_definite_inputs(const Costs& costs, const Sizes& sizes) {
  const int n_nu = sizes.n_lambda + sizes.n_u;
  if (n_nu == 0) return;
  for (int k = 0; k < std::max(costs.G.count(), costs.R.count()); ++k) {
    Eigen::MatrixXd weight = costs.G[k].bottomRightCorner(n_nu, n_nu);
    weight.bottomRightCorner(sizes.n_u, sizes.n_u) += costs.R[k];
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(weight, Eigen::EigenvaluesOnly);
    if (!(eigen.eigenvalues()[0] > 0.0)) {
      refuse(name_of("Costs.G", costs.G, k),
             "a positive definite weight of lambda and, together with R, of u",
             "the eigenvalue " + text(eigen.eigenvalues()[0]));
    }
  }
}

}  // namespace

void check(const Costs& costs, const Sizes& sizes, ProjectionKind projection) {
  qp::check(costs, sizes);
  const ProjectionType& type = projection_type(projection);
  if (type.needs_U || costs.U.size() != 0) require_weight("Costs.U", costs.U, sizes.n_z());
  if (type.check_weights != nullptr) type.check_weights(costs, sizes);
  if (!type.needs_G) return;
  require_weights("Costs.G", costs.G, sizes.n_z(), sizes);
  require_definite_inputs(costs, sizes);
}

}  // namespace c3rt::c3
