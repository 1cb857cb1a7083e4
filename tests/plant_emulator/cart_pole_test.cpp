#include "plant_emulator/cart_pole.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "controller/lcs/simulate.hpp"
#include "controller/model/cart_pole.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;

CartPoleParameters with_step(double step) {
  CartPoleParameters parameters = CartPoleParameters::hardware();
  parameters.step = step;
  return parameters;
}

Vector4d stepped(CartPole& plant, const Vector4d& x, double force) {
  plant.reset(x);
  plant.step(force);
  return plant.state();
}

// of two point masses and the two springs; the pole's height counts from the hinge
double energy(const CartPoleParameters& p, const Vector4d& x) {
  const double v_x = x[2] - p.center_length * std::cos(x[1]) * x[3];
  const double v_z = -p.center_length * std::sin(x[1]) * x[3];
  const double tip = x[0] - p.pole_length * std::sin(x[1]);
  const double depth = std::max(0.0, std::abs(tip) - p.wall_distance);
  return 0.5 * p.cart_mass * x[2] * x[2] + 0.5 * p.pole_mass * (v_x * v_x + v_z * v_z) +
         p.pole_mass * p.gravity * p.center_length * std::cos(x[1]) +
         0.5 * p.wall_stiffness * depth * depth;
}

TEST_CASE("cart pole: free of the walls its accelerations are those of the textbook") {
  const CartPoleParameters p = with_step(1e-3);
  CartPole plant(p);
  support::Random random(51);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector4d x(0.02 * random.uniform(), 0.5 * random.uniform(), 3.0 * random.uniform(),
                     4.0 * random.uniform());
    const double force = 20.0 * random.uniform();
    const double s = std::sin(x[1]), c = std::cos(x[1]), l = p.center_length;
    // [m_c + m_p, −m_p l c; −m_p l c, m_p l²] v̇ = [u − m_p l s θ̇²; m_p g l s]
    Eigen::Matrix2d M;
    M << p.cart_mass + p.pole_mass, -p.pole_mass * l * c, -p.pole_mass * l * c, p.pole_mass * l * l;
    const Vector2d expected = M.inverse() * Vector2d(force - p.pole_mass * l * s * x[3] * x[3],
                                                     p.pole_mass * 9.81 * l * s);
    const Vector4d next = stepped(plant, x, force);
    CHECK(((next - x).tail<2>() / p.step - expected).norm() < 1e-6 * (1.0 + expected.norm()));
    CHECK((next.head<2>() - x.head<2>() - p.step * next.tail<2>()).norm() < 1e-15);
  }
}

TEST_CASE("cart pole: linearised upright it has the A and B of the LCS") {
  const double dt = 1e-3, h = 1e-5;
  CartPole plant(with_step(dt));
  const lcs::Lcs lcs = model::cart_pole(model::CartPoleParameters::hardware(), dt);
  for (int i = 0; i < 4; ++i) {
    const Vector4d away = h * Vector4d::Unit(i);
    const Vector4d column = (stepped(plant, away, 0.0) - stepped(plant, -away, 0.0)) / (2.0 * h);
    CHECK((column.tail<2>() - lcs.A.col(i).tail<2>()).norm() < 1e-8);
    // the plant moves with the new velocity, the LCS with the old one
    CHECK((column.head<2>() - Vector4d::Unit(i).head<2>() - dt * lcs.A.col(i).tail<2>()).norm() <
          1e-8);
  }
  const Vector4d by_force =
      (stepped(plant, Vector4d::Zero(), 1.0) - stepped(plant, Vector4d::Zero(), -1.0)) / 2.0;
  CHECK((by_force.tail<2>() - lcs.B.col(0).tail<2>()).norm() < 1e-8);
}

TEST_CASE("cart pole: upright in a wall it moves as the D, E, F and c of the LCS have it") {
  const double dt = 1e-3;
  CartPole plant(with_step(dt));
  const lcs::Lcs lcs = model::cart_pole(model::CartPoleParameters::hardware(), dt);
  for (const double position : {0.37, 0.41, 0.45, -0.37, -0.41, -0.45}) {
    const Vector4d x(position, 0.0, 0.2, -0.3);
    const lcs::Simulation expected = lcs::simulate(lcs, x, Eigen::MatrixXd::Zero(1, 1));
    REQUIRE(expected.report.ok());
    plant.reset(x);
    CHECK((plant.wall_forces() - expected.lambda.col(0)).norm() < 1e-9);
    plant.step(0.0);
    CHECK((plant.state().tail<2>() - expected.x.col(1).tail<2>()).norm() < 1e-8);
  }
}

TEST_CASE("cart pole: a wall's stiffness, measured by what it gives back, is k at any lean") {
  // the hinge's generalised force is the rate of the spring's energy ½ k depth² over the angle
  const CartPoleParameters p = with_step(1e-3);
  CartPoleParameters without = p;
  without.wall_stiffness = 0.0;
  CartPole plant(p), free(without);
  for (const double angle : {-0.4, -0.1, 0.2}) {
    const Vector4d x(p.wall_distance + 0.05 + p.pole_length * std::sin(angle), angle, 0.0, 0.0);
    const Vector2d change = (stepped(plant, x, 0.0) - stepped(free, x, 0.0)).tail<2>() / p.step;
    const double l = p.center_length, c = std::cos(angle);
    Eigen::Matrix2d M;
    M << p.cart_mass + p.pole_mass, -p.pole_mass * l * c, -p.pole_mass * l * c, p.pole_mass * l * l;
    const auto spring_energy = [&](double position, double at) {
      const double depth = position - p.pole_length * std::sin(at) - p.wall_distance;
      return 0.5 * 100.0 * depth * depth;
    };
    const double h = 1e-5;
    const Vector2d slope(
        (spring_energy(x[0] + h, angle) - spring_energy(x[0] - h, angle)) / (2.0 * h),
        (spring_energy(x[0], angle + h) - spring_energy(x[0], angle - h)) / (2.0 * h));
    CHECK((M * change + slope).norm() < 1e-6 * slope.norm());
  }
}

TEST_CASE("cart pole: falling and bouncing off the walls it keeps its energy") {
  const CartPoleParameters p = with_step(2e-5);
  CartPole plant(p);
  const Vector4d x(0.0, 0.3, 0.5, 0.0);
  plant.reset(x);
  double deepest = 0.0, worst = 0.0;
  for (int i = 0; i < 100000; ++i) {  // 2 s
    plant.step(0.0);
    deepest = std::max(deepest, plant.wall_forces().maxCoeff());
    worst = std::max(worst, std::abs(energy(p, plant.state()) - energy(p, x)));
  }
  CHECK(deepest > 5.0);
  CHECK(worst < 1e-2);  // of several joules; first order in the step
}

TEST_CASE("cart pole: hanging it swings with the period of its linearisation") {
  CartPoleParameters p = with_step(1e-4);
  p.wall_distance = 100.0;
  CartPole plant(p);
  const double small = 1e-3;
  // the common centre of mass at rest, so that it stays
  plant.reset(Vector4d(-p.pole_mass * p.center_length * small / (p.cart_mass + p.pole_mass),
                       M_PI + small, 0.0, 0.0));
  const double omega =
      std::sqrt(p.gravity * (p.cart_mass + p.pole_mass) / (p.center_length * p.cart_mass));
  const int quarter = static_cast<int>(std::lround(0.5 * M_PI / omega / p.step));
  for (int i = 0; i < 4 * quarter; ++i) {
    plant.step(0.0);
    if (i + 1 == 2 * quarter) CHECK(plant.state()[1] - M_PI == Approx(-small).epsilon(1e-3));
  }
  CHECK(plant.state()[1] - M_PI == Approx(small).epsilon(1e-3));
  CHECK(std::abs(plant.state()[2]) < 1e-5);
}

TEST_CASE("cart pole: a damped wall takes energy and never pulls, a rail with friction slows") {
  CartPoleParameters p = with_step(1e-4);
  p.wall_damping = 5.0;
  p.cart_damping = 2.0;
  CartPole plant(p);
  plant.reset(Vector4d(0.42, 0.0, -3.0, 0.0));  // leaving the wall quickly
  CHECK(plant.wall_forces() == Vector2d::Zero());
  plant.reset(Vector4d(0.42, 0.0, 0.4, 0.0));
  CHECK(plant.wall_forces()[0] == Approx(100.0 * 0.03 + 5.0 * 0.4));
  const Vector4d x(0.0, 0.0, 0.4, 0.0);
  CHECK((stepped(plant, x, 0.0)[2] - 0.4) / p.step ==
        Approx(-2.0 * 0.4 / p.cart_mass).epsilon(1e-3));
}

TEST_CASE("cart pole: after a reset the same forces give the same bits") {
  CartPole plant(CartPoleParameters::hardware());
  const auto run = [&] {
    plant.reset(Vector4d(0.3, 0.05, 0.6, 0.0));
    for (int i = 0; i < 500; ++i) plant.step(std::sin(0.1 * i));
    return plant.state();
  };
  const Vector4d first = run();
  CHECK(run() == first);
  CHECK_THROWS_AS(plant.reset(Vector4d::Constant(std::numeric_limits<double>::quiet_NaN())),
                  std::invalid_argument);
}

TEST_CASE("cart pole: a step does not allocate") {
  CartPole plant(CartPoleParameters::hardware());
  plant.reset(Vector4d(0.42, 0.05, 0.6, 0.0));
  const support::AllocationCounter counter;
  for (int i = 0; i < 20; ++i) plant.step(1.0);
  const auto count = counter.count();
  if (support::AllocationCounter::counts()) CHECK(count == 0);
}

TEST_CASE("cart pole: parameters out of range are refused by name") {
  CartPoleParameters p = CartPoleParameters::hardware();
  p.pole_mass = 0.0;
  CHECK_THROWS_WITH(CartPole(p), "cart pole: pole_mass must be positive");
  p = CartPoleParameters::hardware();
  p.wall_stiffness = -1.0;
  CHECK_THROWS_WITH(CartPole(p), "cart pole: wall_stiffness must not be negative");
  p = CartPoleParameters::hardware();
  p.step = 0.1;
  CHECK_THROWS_WITH(CartPole(p), "cart pole: step must be in (0, 0.01] s");
}

}  // namespace
