#include "controller/model/balls_model.hpp"

#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "controller/lcs/simulate.hpp"
#include "controller/model/ball_model.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Catch::Matchers::Equals;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using model::ContactPair;

namespace {

constexpr double kGravity = 9.81, kTip = 0.0195, kTable = -0.01;
constexpr int kE = ContactPair::kEndEffector;

// balls of different sizes and masses, so that none is taken for another
model::BallsModelParameters parameters(int balls, double mu) {
  model::BallsModelParameters result{0.01, kTip, kTable, mu, mu, {}};
  for (int i = 0; i < balls; ++i) result.balls.push_back({0.132 + 0.05 * i, 0.0315 + 0.003 * i});
  return result;
}

const Vector3d kHover(0.0, 0.0, kGravity * 0.01);

VectorXd random_state(support::Random& random, int balls) {
  const model::BallsLayout layout{balls};
  VectorXd x = 0.3 * random.vector(layout.n_x());
  x.segment<3>(0) += Vector3d(0.5, 0.0, 0.4);
  for (int i = 0; i < balls; ++i)
    x.segment<2>(layout.p_WB(i)) << 0.2 * i + 0.02 * random.uniform(), 0.05 * random.uniform();
  return x;
}

VectorXd moved(const VectorXd& x, double dt) {
  VectorXd result = x;
  result.head(x.size() / 2) += dt * x.tail(x.size() / 2);
  return result;
}

model::ContactSystem all_contacts(const model::BallsModelParameters& p, const VectorXd& x) {
  return model::balls_contact_system(p, model::all_contact_pairs(static_cast<int>(p.balls.size())),
                                     x);
}

lcs::Simulation one_step(const lcs::Lcs& lcs, const VectorXd& x, const VectorXd& u) {
  lcs::check(lcs);
  lcs::Simulation result = lcs::simulate(lcs, x, MatrixXd(u));
  REQUIRE(result.report.ok());
  return result;
}

}  // namespace

TEST_CASE("balls model: 2 and 3 balls have the sizes of the paper") {
  support::Random random(41);
  const model::ContactSystem two = all_contacts(parameters(2, 1.0), random_state(random, 2));
  const model::ContactSystem three = all_contacts(parameters(3, 1.0), random_state(random, 3));
  CHECK(lcs::sizes(model::stewart_trinkle(two, 0.1)).n_x == 14);
  CHECK(lcs::sizes(model::stewart_trinkle(two, 0.1)).n_lambda == 18);
  CHECK(lcs::sizes(model::stewart_trinkle(two, 0.1)).n_u == 3);
  CHECK(lcs::sizes(model::anitescu(three, 0.1)).n_x == 18);
  CHECK(lcs::sizes(model::anitescu(three, 0.1)).n_lambda == 24);
  CHECK(lcs::sizes(model::anitescu(three, 0.1)).n_u == 3);
}

TEST_CASE("balls model: J_n is the rate of the gap, by finite differences") {
  support::Random random(42);
  for (int trial = 0; trial < 10; ++trial) {
    const model::BallsModelParameters p = parameters(3, 1.0);
    const VectorXd x = random_state(random, 3);
    const double h = 1e-6;
    const VectorXd rate =
        (all_contacts(p, moved(x, h)).phi - all_contacts(p, moved(x, -h)).phi) / (2.0 * h);
    CHECK((all_contacts(p, x).J_n * x.tail(9) - rate).norm() < 1e-7);
  }
}

TEST_CASE("balls model: J_t is the speed of the rolling balls' material points past each other") {
  support::Random random(43);
  const model::BallsLayout layout{3};
  const model::BallsModelParameters p = parameters(3, 1.0);
  const std::vector<ContactPair> pairs = model::all_contact_pairs(3);
  for (int trial = 0; trial < 10; ++trial) {
    const VectorXd x = random_state(random, 3);
    const auto center = [&](int body) -> Vector3d {
      if (body == kE) return x.head<3>();
      const Vector2d xy = x.segment<2>(layout.p_WB(body));
      return {xy.x(), xy.y(), kTable + p.balls[static_cast<std::size_t>(body)].radius};
    };
    // where a point of the body goes in the time dt: the ball turns by the length it rolls
    const auto carried = [&](int body, const Vector3d& from_center, double dt) -> Vector3d {
      if (body == kE) return center(body) + from_center + dt * x.segment<3>(layout.v_WE());
      const Vector2d v = x.segment<2>(layout.v_WB(body));
      const double angle = dt * v.norm() / p.balls[static_cast<std::size_t>(body)].radius;
      const Vector3d axis = Vector3d(-v.y(), v.x(), 0.0).normalized();
      return center(body) + Vector3d(dt * v.x(), dt * v.y(), 0.0) +
             Eigen::AngleAxisd(angle, axis) * from_center;
    };
    const auto radius = [&](int body) {
      return body == kE ? kTip : p.balls[static_cast<std::size_t>(body)].radius;
    };
    const VectorXd slip = all_contacts(p, x).J_t * x.tail(9);
    const double h = 1e-6;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto [first, second] = pairs[i];
      const Vector3d n = (center(first) - center(second)).normalized();
      const Vector3d r_first = -radius(first) * n, r_second = radius(second) * n;
      const Vector3d velocity = (carried(first, r_first, h) - carried(first, r_first, -h) -
                                 carried(second, r_second, h) + carried(second, r_second, -h)) /
                                (2.0 * h);
      Vector3d t, s;
      model::tangents(n, t, s);
      const Eigen::Vector4d expected(t.dot(velocity), -t.dot(velocity), s.dot(velocity),
                                     -s.dot(velocity));
      CHECK((slip.segment<4>(4 * static_cast<Eigen::Index>(i)) - expected).norm() < 1e-7);
    }
  }
}

TEST_CASE("balls model: pushed without friction, end effector and balls share F over 7/5 m each") {
  const model::BallsModelParameters p = parameters(2, 0.0);
  const model::BallsLayout layout{2};
  const double r_0 = p.balls[0].radius, dt = 0.01, force = 0.5;
  // in a row along y, touching: end effector level with ball 0, and two balls
  VectorXd x = VectorXd::Zero(layout.n_x());
  x.head<3>() << 0.5, 0.0, kTable + r_0;
  x.segment<2>(layout.p_WB(0)) << 0.5, kTip + r_0;
  x.segment<2>(layout.p_WB(1)) << 0.5, 1.0;  // far away
  lcs::Simulation next =
      one_step(model::stewart_trinkle(all_contacts(p, x), dt), x, kHover + Vector3d(0, force, 0));
  const double both = force / (0.01 + 1.4 * p.balls[0].mass);
  CHECK(next.x(layout.v_WB(0) + 1, 1) == Approx(dt * both));
  CHECK(next.x(layout.v_WE() + 1, 1) == Approx(dt * both));
  CHECK(std::abs(next.x(layout.v_WB(1) + 1, 1)) < 1e-12);
  // the force of the contact, on the ball alone
  CHECK(next.lambda(3, 0) / (1.4 * p.balls[0].mass) == Approx(both));

  const double r_1 = p.balls[1].radius;  // the centres are at different heights
  x[layout.p_WB(1) + 1] = kTip + r_0 + 2.0 * std::sqrt(r_0 * r_1);
  next =
      one_step(model::stewart_trinkle(all_contacts(p, x), dt), x, kHover + Vector3d(0, force, 0));
  const double all = force / (0.01 + 1.4 * (p.balls[0].mass + p.balls[1].mass));
  CHECK(next.x(layout.v_WB(0) + 1, 1) == Approx(dt * all));
  CHECK(next.x(layout.v_WB(1) + 1, 1) == Approx(dt * all));
}

TEST_CASE("balls model: a pair that is left out is not felt") {
  const model::BallsModelParameters p = parameters(1, 0.0);
  const model::BallsLayout layout{1};
  const double dt = 0.01, force = 0.5;
  VectorXd x = VectorXd::Zero(layout.n_x());
  x.head<3>() << 0.5, 0.0, kTable + p.balls[0].radius;
  x.segment<2>(layout.p_WB(0)) << 0.5, kTip + p.balls[0].radius;
  const lcs::Lcs lcs = model::stewart_trinkle(model::balls_contact_system(p, {}, x), dt);
  CHECK(lcs::sizes(lcs).n_lambda == 0);
  const lcs::Simulation next = one_step(lcs, x, kHover + Vector3d(0, force, 0));
  CHECK(next.x(layout.v_WE() + 1, 1) == Approx(dt * force / 0.01));
  CHECK(std::abs(next.x(layout.v_WB(0) + 1, 1)) < 1e-12);
}

TEST_CASE("balls model: one ball moves like the full model whose table does not let it slip") {
  // pushed in a vertical plane, where the full model's ball does not turn about the vertical
  const model::BallsModelParameters reduced{0.01, kTip, kTable, 0.6, 0.6, {{0.132, 0.0315}}};
  const model::BallModelParameters full{0.01, kTip, 0.132, 0.0315, kTable, 0.6, 20.0};
  const model::BallsLayout layout{1};
  using L = model::BallLayout;
  support::Random random(44);
  const double dt = 0.01;
  int pushed = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const double elevation = random.uniform(0.1, 1.5), v = random.uniform(-0.1, 0.1);
    scene::Scene state;
    state.body(0).p_WB = Vector3d(0.5, 0.1, kTable + 0.0315);
    state.effector.p_WE =
        state.body(0).p_WB + (kTip + 0.0315 + random.uniform(0.0, 2e-4)) *
                                 Vector3d(0.0, -std::cos(elevation), std::sin(elevation));
    state.effector.v_WE = Vector3d(0.0, 0.1 * random.uniform(), 0.1 * random.uniform());
    state.body(0).v_WB = Vector3d(0.0, v, 0.0);
    state.body(0).omega_WB = Vector3d(-v / 0.0315, 0.0, 0.0);
    const Vector3d u = kHover + Vector3d(0.0, 2.0 * random.uniform(), 2.0 * random.uniform());
    VectorXd x(layout.n_x());
    x << state.effector.p_WE, state.body(0).p_WB.head<2>(), state.effector.v_WE,
        state.body(0).v_WB.head<2>();

    const lcs::Simulation expected =
        one_step(model::stewart_trinkle(model::ball_contact_system(full, state), dt),
                 model::ball_state(state), u);
    const lcs::Simulation next =
        one_step(model::stewart_trinkle(all_contacts(reduced, x), dt), x, u);
    CHECK(
        (next.x.col(1).segment<2>(layout.v_WB(0)) - expected.x.col(1).segment<2>(L::v_WB)).norm() <
        1e-7);
    CHECK((next.x.col(1).segment<3>(layout.v_WE()) - expected.x.col(1).segment<3>(L::v_WE)).norm() <
          1e-6);
    pushed += expected.lambda(L::normal_end_effector, 0) > 1e-3 ? 1 : 0;
  }
  CHECK(pushed > 10);
}

TEST_CASE("balls model: thrown together, balls and end effector do not pass through each other") {
  support::Random random(45);
  const double dt = 0.02;
  int touching = 0;
  for (int trial = 0; trial < 40; ++trial) {
    // three balls in a heap, gaps up to 2 mm, the end effector at one of them
    const model::BallsModelParameters p = parameters(3, 0.8);
    const model::BallsLayout layout{3};
    VectorXd x = 0.3 * random.vector(layout.n_x());
    const double side = 0.068 + random.uniform(0.001, 0.003);
    x.segment<2>(layout.p_WB(0)) << 0.0, 0.0;
    x.segment<2>(layout.p_WB(1)) << side, 0.0;
    x.segment<2>(layout.p_WB(2)) << 0.5 * side, 0.9 * side;
    const Vector3d direction =
        Vector3d(-1.0, random.uniform(), random.uniform(0.0, 1.0)).normalized();
    x.head<3>() = Vector3d(0.0, 0.0, kTable + p.balls[0].radius) +
                  (kTip + p.balls[0].radius + random.uniform(0.0, 0.002)) * direction;
    const model::ContactSystem system = all_contacts(p, x);
    const VectorXd u = kHover + random.vector(3);
    for (const lcs::Lcs& lcs : {model::stewart_trinkle(system, dt), model::anitescu(system, dt)}) {
      const lcs::Simulation next = one_step(lcs, x, u);
      const VectorXd gaps = system.phi + system.J_n * (next.x.col(1) - x).head(layout.n_v());
      CHECK(gaps.minCoeff() > -1e-9);
      touching += next.lambda.maxCoeff() > 1e-3 ? 1 : 0;
    }
  }
  CHECK(touching > 20);
}

TEST_CASE("balls model: a pair or a state that cannot be is refused by name") {
  const model::BallsModelParameters p = parameters(2, 1.0);
  const VectorXd x = VectorXd::Zero(14);
  CHECK_THROWS_WITH(model::balls_contact_system(p, {{kE, 0}, {0, 2}}, x),
                    Equals("contact pair 1: expected two different bodies of -1 (the end effector) "
                           "to 1, got 0 and 2"));
  CHECK_THROWS_AS(model::balls_contact_system(p, {{1, 1}}, x), std::invalid_argument);
  CHECK_THROWS_AS(model::balls_contact_system(p, {{-2, 1}}, x), std::invalid_argument);
  CHECK_THROWS_WITH(model::balls_contact_system(p, {}, VectorXd::Zero(18)),
                    Equals("balls model: x: expected 14 numbers, got 18"));
}
