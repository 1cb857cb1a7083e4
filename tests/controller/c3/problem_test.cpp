#include "controller/c3/problem.hpp"

#include <limits>

#include <catch2/catch.hpp>

#include "controller/c3/solver.hpp"

using namespace c3rt::c3;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const Sizes kSizes{2, 1, 1, 3};

Costs good_costs() {
  return {MatrixXd::Identity(2, 2), MatrixXd::Identity(2, 2), MatrixXd::Identity(1, 1),
          MatrixXd::Identity(4, 4), MatrixXd::Identity(4, 4)};
}

Settings good_settings() {
  return {3,   0.1,  2.0, QpBackend::kDirect, {1000, 1e-6, 0.1, 50, false}, ProjectionKind::kMiqp,
          100, false};
}

}  // namespace

TEST_CASE("costs: a wrong shape is refused by name, with what was expected") {
  Costs costs = good_costs();
  REQUIRE_NOTHROW(check(costs, kSizes, ProjectionKind::kMiqp));
  costs.U = MatrixXd::Identity(3, 3);
  REQUIRE_THROWS_WITH(check(costs, kSizes, ProjectionKind::kMiqp),
                      Equals("Costs.U: expected 4 x 4, got 3 x 3"));
  costs = good_costs();
  costs.R = MatrixXd::Identity(2, 2);
  REQUIRE_THROWS_WITH(check(costs, kSizes, ProjectionKind::kMiqp),
                      Equals("Costs.R: expected 1 x 1, got 2 x 2"));
}

TEST_CASE("costs: NaN, asymmetric and indefinite weights are refused by name") {
  Costs costs = good_costs();
  costs.Q[0](0, 0) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_THROWS_WITH(check(costs, kSizes, ProjectionKind::kMiqp),
                      Equals("Costs.Q: expected finite numbers, got NaN or infinity"));
  costs = good_costs();
  costs.Q_N(0, 1) = 0.5;
  REQUIRE_THROWS_WITH(check(costs, kSizes, ProjectionKind::kMiqp),
                      Equals("Costs.Q_N: expected a symmetric matrix, got an asymmetry of 0.5"));
  costs = good_costs();
  costs.U(2, 2) = -1.0;
  REQUIRE_THROWS_WITH(
      check(costs, kSizes, ProjectionKind::kMiqp),
      Equals("Costs.U: expected a positive semidefinite matrix, got the eigenvalue -1"));
  costs = good_costs();
  costs.G[0](0, 1) = costs.G[0](1, 0) = 3.0;
  REQUIRE_THROWS_WITH(
      check(costs, kSizes, ProjectionKind::kMiqp),
      Equals("Costs.G: expected a positive semidefinite matrix, got the eigenvalue -2"));
}

TEST_CASE("costs: a force without weight is refused, an input that R weighs is not") {
  Costs costs = good_costs();
  costs.G[0](3, 3) = 0.0;
  REQUIRE_NOTHROW(check(costs, kSizes, ProjectionKind::kMiqp));
  costs.R[0](0, 0) = 0.0;
  REQUIRE_THROWS_WITH(check(costs, kSizes, ProjectionKind::kMiqp),
                      Contains("Costs.G: expected a positive definite"));
  costs = good_costs();
  costs.G[0](2, 2) = 0.0;
  REQUIRE_THROWS_WITH(check(costs, kSizes, ProjectionKind::kMiqp),
                      Contains("Costs.G: expected a positive definite"));
}

TEST_CASE("bounds: wrong length, NaN and crossed limits are refused by name") {
  Constraints bounds;
  REQUIRE_NOTHROW(check(bounds, kSizes));
  bounds.u_min = VectorXd::Zero(2);
  REQUIRE_THROWS_WITH(check(bounds, kSizes),
                      Equals("Constraints.u_min: expected 1 values or none, got 2"));
  bounds = {};
  bounds.lambda_max = VectorXd::Constant(1, std::numeric_limits<double>::quiet_NaN());
  REQUIRE_THROWS_WITH(check(bounds, kSizes),
                      Equals("Constraints.lambda_max: expected numbers or infinity, got NaN"));
  bounds = {};
  bounds.x_min = VectorXd::Constant(2, 1.0);
  bounds.x_max = VectorXd::Constant(2, 0.5);
  REQUIRE_THROWS_WITH(
      check(bounds, kSizes),
      Equals("Constraints.x_min[0]: expected at most Constraints.x_max = 0.5, got 1"));
}

TEST_CASE("sizes and settings: what cannot be is refused by name") {
  REQUIRE_NOTHROW(check(Sizes{2, 0, 1, 3}));
  REQUIRE_NOTHROW(check(Sizes{2, 1, 0, 3}));
  REQUIRE_THROWS_WITH(check(Sizes{2, -1, 1, 3}),
                      Equals("Sizes.n_lambda: expected 0 or more, got -1"));
  Settings settings = good_settings();
  REQUIRE_NOTHROW(check(settings));
  settings.admm_iterations = 0;
  REQUIRE_THROWS_WITH(check(settings),
                      Equals("Settings.admm_iterations: expected 1 or more, got 0"));
  settings = good_settings();
  settings.rho = -1.0;
  REQUIRE_THROWS_WITH(check(settings), Contains("Settings.rho: expected a positive number"));
  settings = good_settings();
  settings.qp = QpBackend::kOsqp;
  settings.osqp.eps = 0.0;
  REQUIRE_THROWS_WITH(check(settings), Contains("Settings.osqp.eps: expected a positive number"));
}
