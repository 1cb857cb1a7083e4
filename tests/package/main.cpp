// One C3 solve of the cart-pole between soft walls with the exact projection; prints u_0 [N].
#include <cstdio>

#include <Eigen/Core>

#include "controller/c3/solver.hpp"
#include "controller/lcs/riccati.hpp"
#include "controller/model/cart_pole.hpp"

int main() {
  using namespace c3rt;
  using Eigen::MatrixXd;

  const lcs::Lcs lcs = model::cart_pole(model::CartPoleParameters::simulated(), 0.01);
  const c3::Sizes sizes{4, 2, 1, 10};  // n_x, n_lambda, n_u, N

  c3::Costs costs;
  const MatrixXd Q = Eigen::Vector4d(10.0, 3.0, 1.0, 1.0).asDiagonal();
  const MatrixXd R = MatrixXd::Identity(1, 1);
  costs.Q = Q;
  costs.R = R;
  costs.Q_N = lcs::riccati(lcs.A, lcs.B, Q, R);
  costs.G = MatrixXd::Identity(sizes.n_z(), sizes.n_z());
  costs.U = MatrixXd::Identity(sizes.n_z(), sizes.n_z());
  sizes.x(costs.U.diagonal()).setConstant(1000.0);

  c3::Settings settings{};
  settings.admm_iterations = 10;
  settings.rho = 0.1;
  settings.rho_scale = 2.0;
  settings.qp = c3::QpBackend::kDirect;
  settings.projection = c3::ProjectionKind::kMiqp;
  settings.max_nodes = 1000;

  c3::Solver solver(sizes, settings);
  solver.set_costs(costs);
  const c3::Solution& solution =
      solver.solve(lcs, Eigen::Vector4d(0.1, -0.3, 0.0, 0.0), MatrixXd::Zero(4, sizes.N + 1));
  if (solution.status != c3::SolveStatus::kOk) return 1;
  std::printf("%.17g\n", solution.u_0()[0]);
  return 0;
}
