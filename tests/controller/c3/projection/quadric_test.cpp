#include "controller/c3/projection/quadric.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "tests/support/random.hpp"

using namespace c3rt;
using c3::nearest_on_quadric;
using Eigen::VectorXd;

namespace {

double constraint(double q_0, const VectorXd& g, const VectorXd& curvature, const VectorXd& h) {
  return q_0 + g.dot(h) + h.dot(curvature.cwiseProduct(h));
}

/// The least distance from `a` to the quadric by looking along many directions.
double look_around(support::Random& random, double q_0, const VectorXd& g,
                   const VectorXd& curvature, const VectorXd& a, int directions) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < directions; ++i) {
    VectorXd d = random.vector(a.size());
    if (a.size() == 2) {
      const double angle = 3.14159265358979 * i / directions;
      d << std::cos(angle), std::sin(angle);
    }
    d.normalize();
    // q(a + t d) = q + s t + r t²
    const double q = constraint(q_0, g, curvature, a);
    const double s = d.dot(g + 2.0 * curvature.cwiseProduct(a));
    const double r = d.dot(curvature.cwiseProduct(d));
    const double root = s * s - 4.0 * r * q;
    if (root < 0.0) continue;
    const double larger = std::abs(s) + std::sqrt(root);
    if (larger > 0.0) best = std::min(best, std::abs(2.0 * q) / larger);
  }
  return best;
}

}  // namespace

TEST_CASE("quadric: the point is on it, its distance is along the normal, nothing else is nearer") {
  support::Random random(41);
  int reached = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 2 + trial % 3;
    const VectorXd g = random.vector(n), curvature = random.vector(n);
    const VectorXd a = 2.0 * random.vector(n);
    const double q_0 = random.uniform();
    VectorXd h(n);
    const double rest = nearest_on_quadric(q_0, g, curvature, a, h);
    const double nearest = look_around(random, q_0, g, curvature, a, 4000);
    CAPTURE(trial, n, curvature.transpose());
    if (nearest == std::numeric_limits<double>::infinity()) continue;
    ++reached;
    CHECK(std::abs(rest) < 1e-12);
    CHECK(std::abs(constraint(q_0, g, curvature, h)) < 1e-12 * (1.0 + h.squaredNorm()));
    const VectorXd normal = (g + 2.0 * curvature.cwiseProduct(h)).normalized();
    const VectorXd step = h - a;
    CHECK((step - normal * normal.dot(step)).norm() < 1e-7 * (1e-3 + step.norm()));
    CHECK(step.norm() <= nearest * (1.0 + 1e-9) + 1e-12);
    if (n == 2) CHECK(step.norm() >= nearest * (1.0 - 1e-3) - 1e-9);
  }
  REQUIRE(reached > 200);
}

TEST_CASE(
    "quadric: from the middle of a hyperbola, where no multiplier inside the interval reaches") {
  const VectorXd curvature = Eigen::Vector2d(1.0, -2.0);
  VectorXd h(2);
  // h_x² − 2 h_y² + 1 = 0 from 0: the nearest points are (0, ±√½)
  nearest_on_quadric(1.0, VectorXd::Zero(2), curvature, VectorXd::Zero(2), h);
  REQUIRE(h[0] == Approx(0.0).margin(1e-9));
  REQUIRE(std::abs(h[1]) == Approx(std::sqrt(0.5)));
  // the mirror image: −h_x² + 2 h_y² − 1 = 0
  nearest_on_quadric(-1.0, VectorXd::Zero(2), -curvature, VectorXd::Zero(2), h);
  REQUIRE(std::abs(h[1]) == Approx(std::sqrt(0.5)));
  // from (0.3, 0): along the normal at (0.3/1.5, ·), that is h_x = 0.2
  nearest_on_quadric(1.0, VectorXd::Zero(2), curvature, Eigen::Vector2d(0.3, 0.0), h);
  REQUIRE(h[0] == Approx(0.2).epsilon(1e-8));
  REQUIRE(std::abs(h[1]) == Approx(std::sqrt(0.52)).epsilon(1e-8));
}

TEST_CASE("quadric: a plane, a circle from inside and outside, a point of it, and an empty one") {
  VectorXd h(2);
  const VectorXd flat = VectorXd::Zero(2), round = VectorXd::Ones(2);
  REQUIRE(nearest_on_quadric(-5.0, Eigen::Vector2d(3.0, 4.0), flat, flat, h) ==
          Approx(0.0).margin(1e-14));
  REQUIRE(h.isApprox(Eigen::Vector2d(0.6, 0.8)));
  nearest_on_quadric(-1.0, flat, round, Eigen::Vector2d(3.0, 4.0), h);
  REQUIRE(h.isApprox(Eigen::Vector2d(0.6, 0.8)));
  nearest_on_quadric(-1.0, flat, round, Eigen::Vector2d(0.3, 0.4), h);
  REQUIRE(h.isApprox(Eigen::Vector2d(0.6, 0.8)));
  nearest_on_quadric(-1.0, flat, round, flat, h);  // its centre: every point is as near
  REQUIRE(h.norm() == Approx(1.0));
  nearest_on_quadric(-25.0, flat, round, Eigen::Vector2d(3.0, 4.0), h);
  REQUIRE(h == Eigen::Vector2d(3.0, 4.0));
  REQUIRE(nearest_on_quadric(1.0, flat, round, Eigen::Vector2d(3.0, 4.0), h) >= 1.0);
  REQUIRE(h.allFinite());
  REQUIRE(nearest_on_quadric(1.0, flat, flat, Eigen::Vector2d(3.0, 4.0), h) == 1.0);
  REQUIRE(h.allFinite());
}

TEST_CASE("quadric: units do not matter") {
  support::Random random(42);
  for (int trial = 0; trial < 200; ++trial) {
    const VectorXd g = random.vector(3), a = random.vector(3);
    VectorXd curvature = random.vector(3), h(3), scaled(3);
    curvature[0] = -1.0;
    curvature[1] = 1.0;  // it has both signs, so there is a point
    const double length = std::pow(10.0, random.index(17) - 8);
    const double unit = std::pow(10.0, random.index(17) - 8);
    nearest_on_quadric(0.5, g, curvature, a, h);
    nearest_on_quadric(0.5 * unit, unit / length * g, unit / (length * length) * curvature,
                       length * a, scaled);
    CAPTURE(trial, length, unit);
    CHECK((scaled / length - h).norm() < 1e-6 * (1.0 + h.norm()));
  }
}
