#include <algorithm>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "controller/c3/projection.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::VectorXd;

namespace {

constexpr Sizes kSizes{2, 3, 1, 1};

VectorXd project(const PlusWeights& weights, const VectorXd& v,
                 ProjectionReport* report = nullptr) {
  Costs costs;
  costs.plus = weights;
  const auto projection = make_plus_projection(kSizes);
  projection->set_weights(costs);
  projection->start({});
  VectorXd delta(v.size());
  const ProjectionReport made = projection->project(v, delta, {});
  if (report != nullptr) *report = made;
  return delta;
}

PlusWeights weighing(const VectorXd& u_lambda, const VectorXd& u_eta) {
  return {VectorXd::Ones(3), VectorXd::Ones(3), u_lambda, u_eta};
}

/// Least u_λ (λ−a)² + u_η (η−b)² over a grid on both half-axes.
double grid(double u_lambda, double u_eta, double a, double b) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 3000; ++i) {
    const double t = 1e-3 * i;
    best = std::min(best, u_lambda * (t - a) * (t - a) + u_eta * b * b);
    best = std::min(best, u_lambda * a * a + u_eta * (t - b) * (t - b));
  }
  return best;
}

}  // namespace

TEST_CASE("C3+ projection: pair by pair the nearest point of the two half-axes, x and u unmoved") {
  support::Random random(51);
  for (int trial = 0; trial < 500; ++trial) {
    const VectorXd v = 2.0 * random.vector(9);
    const VectorXd u_lambda = (2.0 * random.vector(3)).array().exp();
    const VectorXd u_eta = (2.0 * random.vector(3)).array().exp();
    ProjectionReport report{};
    const VectorXd delta = project(weighing(u_lambda, u_eta), v, &report);
    REQUIRE(report.status == ProjectionStatus::kSolved);
    REQUIRE(kSizes.x(delta) == kSizes.x(v));
    REQUIRE(kSizes.u(delta) == kSizes.u(v));
    double objective = 0.0;
    for (int i = 0; i < 3; ++i) {
      const double lambda = kSizes.lambda(delta)[i], eta = kSizes.eta(delta)[i];
      const double a = kSizes.lambda(v)[i], b = kSizes.eta(v)[i];
      CAPTURE(trial, i, a, b, u_lambda[i], u_eta[i]);
      CHECK(lambda >= 0.0);
      CHECK(eta >= 0.0);
      CHECK(lambda * eta == 0.0);
      const double value =
          u_lambda[i] * (lambda - a) * (lambda - a) + u_eta[i] * (eta - b) * (eta - b);
      const double best = grid(u_lambda[i], u_eta[i], a, b);
      CHECK(value <= best + 1e-12);
      CHECK(value >= best - 1e-6 * (u_lambda[i] + u_eta[i]));  // half a step of the grid, squared
      objective += value;
    }
    CHECK(report.objective == Approx(objective));
  }
}

TEST_CASE("C3+ projection: of two negative ones nothing remains, a tie keeps the force") {
  const VectorXd ones = VectorXd::Ones(3);
  VectorXd v(9);
  v << 1, 2, /*λ*/ -1, 0.5, 3, /*u*/ 4, /*η*/ -2, 0.5, 0;
  const VectorXd delta = project(weighing(ones, ones), v);
  REQUIRE(kSizes.lambda(delta) == Eigen::Vector3d(0.0, 0.5, 3.0));
  REQUIRE(kSizes.eta(delta) == Eigen::Vector3d(0.0, 0.0, 0.0));
  // heavier gaps win the same tie
  const VectorXd heavy = project(weighing(ones, 4.0 * ones), v);
  REQUIRE(kSizes.lambda(heavy) == Eigen::Vector3d(0.0, 0.0, 3.0));
  REQUIRE(kSizes.eta(heavy) == Eigen::Vector3d(0.0, 0.5, 0.0));
}

TEST_CASE("C3+ projection: a point of the set stays where it is, and NaN is a status") {
  const VectorXd ones = VectorXd::Ones(3);
  VectorXd v(9);
  v << 1, 2, 0, 0.5, 0, 4, 3, 0, 0;
  ProjectionReport report{};
  REQUIRE(project(weighing(ones, 0.01 * ones), v, &report) == v);
  REQUIRE(report.objective == 0.0);
  v[8] = std::numeric_limits<double>::quiet_NaN();
  project(weighing(ones, ones), v, &report);
  REQUIRE(report.status == ProjectionStatus::kNotFinite);
}
