#include "controller/model/contact_system.hpp"

#include <cmath>
#include <stdexcept>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "controller/lcs/simulate.hpp"
#include "controller/model/ball_model.hpp"
#include "controller/model/cart_pole.hpp"
#include "controller/model/linearise.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kMass = 2.0, kGravity = 9.81, kStep = 0.01;

// a point mass above the plane z = 0, pushed by a force; edges +x −x +y −y
model::ContactSystem point_on_plane(const Vector3d& p, double mu) {
  model::ContactSystem system;
  system.q = p;
  system.N_q = Eigen::Matrix3d::Identity();
  system.N_q_plus = Eigen::Matrix3d::Identity();
  system.J_f_q = Eigen::Matrix3d::Zero();
  system.J_f_v = Eigen::Matrix3d::Zero();
  system.J_f_u = Eigen::Matrix3d::Identity() / kMass;
  system.d_v = Vector3d(0.0, 0.0, -kGravity);
  system.M_inverse = Eigen::Matrix3d::Identity() / kMass;
  system.phi = VectorXd::Constant(1, p.z());
  system.J_n = Eigen::RowVector3d(0.0, 0.0, 1.0);
  system.J_t.resize(4, 3);
  system.J_t << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0;
  system.mu = VectorXd::Constant(1, mu);
  return system;
}

lcs::Simulation one_step(const lcs::Lcs& lcs, const VectorXd& x, const VectorXd& u) {
  lcs::Simulation result = lcs::simulate(lcs, x, MatrixXd(u));
  REQUIRE(result.report.ok());
  return result;
}

VectorXd state(const Vector3d& p, const Vector3d& v) { return (VectorXd(6) << p, v).finished(); }

scene::Scene random_ball_state(support::Random& random, double height) {
  scene::Scene scene;
  scene::Body& ball = scene.body(0);
  ball.p_WB = Vector3d(0.5, 0.1, 0.0315 + height);
  const Vector3d direction(random.uniform(), random.uniform(), random.uniform(0.2, 1.0));
  scene.effector.p_WE =
      ball.p_WB + (0.0195 + 0.0315 + random.uniform(-0.002, 0.002)) * direction.normalized();
  ball.q_WB =
      Eigen::Quaterniond(1.5, random.uniform(), random.uniform(), random.uniform()).normalized();
  scene.effector.v_WE = random.vector(3);
  ball.omega_WB = 3.0 * random.vector(3);
  ball.v_WB = 0.3 * random.vector(3);
  return scene;
}

// the cart-pole without the small angles: inverse mass matrix, gravity and centrifugal force
struct NonlinearCartPole {
  model::CartPoleParameters parameters = model::CartPoleParameters::simulated();

  template <typename Scalar>
  model::VectorOf<Scalar> operator()(const model::VectorOf<Scalar>& q,
                                     const model::VectorOf<Scalar>& v,
                                     const model::VectorOf<Scalar>& u) const {
    using std::cos;
    using std::sin;
    const double m_c = parameters.cart_mass, m_p = parameters.pole_mass,
                 l = parameters.center_length, g = parameters.gravity;
    const Scalar s = sin(q[1]), c = cos(q[1]);
    // [m_c + m_p, −m_p l c; −m_p l c, m_p l²] v̇ = [u − m_p l s θ̇²; m_p g l s]
    const Scalar force = u[0] - m_p * l * s * v[1] * v[1];
    const Scalar acceleration = (force + m_p * g * s * c) / (m_c + m_p * s * s);
    model::VectorOf<Scalar> result(2);
    result[0] = acceleration;
    result[1] = (acceleration * c + g * s) / l;
    return result;
  }
};

}  // namespace

TEST_CASE("anitescu: a mass in the air falls freely and is pushed by no impulse") {
  const Vector3d p(0.1, -0.2, 1.0), v(0.3, 0.4, -0.5);
  const lcs::Lcs lcs = model::anitescu(point_on_plane(p, 0.7), kStep);
  lcs::check(lcs);
  const lcs::Simulation next = one_step(lcs, state(p, v), Vector3d(4.0, 0.0, 0.0));
  const Vector3d v_next = v + kStep * Vector3d(2.0, 0.0, -kGravity);
  CHECK((next.x.col(1) - state(p + kStep * v_next, v_next)).norm() < 1e-12);
  CHECK(next.lambda.norm() == 0.0);
}

TEST_CASE("anitescu: a push within the cone is held, and the impulses carry weight and push") {
  const double mu = 0.5;
  const lcs::Lcs lcs = model::anitescu(point_on_plane(Vector3d::Zero(), mu), kStep);
  const Vector3d push(0.4 * mu * kMass * kGravity, -0.5 * mu * kMass * kGravity, 0.0);
  const lcs::Simulation next = one_step(lcs, VectorXd::Zero(6), push);
  CHECK(next.x.col(1).norm() < 1e-9);
  const VectorXd lambda = next.lambda.col(0);
  CHECK(lambda.sum() == Approx(kStep * kMass * kGravity));
  CHECK(mu * (lambda[0] - lambda[1]) == Approx(-kStep * push.x()));
  CHECK(mu * (lambda[2] - lambda[3]) == Approx(-kStep * push.y()));
}

TEST_CASE("anitescu: what slides is slowed and lifted as the convex cone has it") {
  // the edge against the sliding alone acts: (v_x, v_z) changes along (−μ, 1) until v_z = μ v_x
  const double mu = 0.5, v = 2.0;
  const lcs::Lcs lcs = model::anitescu(point_on_plane(Vector3d::Zero(), mu), kStep);
  const lcs::Simulation next =
      one_step(lcs, state(Vector3d::Zero(), Vector3d(v, 0.0, 0.0)), Vector3d::Zero());
  const double v_x = (v - mu * kGravity * kStep) / (1.0 + mu * mu);
  CHECK(next.x(3, 1) == Approx(v_x));
  CHECK(next.x(4, 1) == Approx(0.0).margin(1e-12));
  CHECK(next.x(5, 1) == Approx(mu * v_x));
}

TEST_CASE("anitescu: F is symmetric and positive semidefinite at every state") {
  support::Random random(31);
  for (int trial = 0; trial < 30; ++trial) {
    const model::BallModelParameters ball{
        0.01, 0.0195, 0.132, 0.0315, 0.0, random.uniform(0, 2.0), random.uniform(0, 2.0)};
    const lcs::Lcs lcs =
        model::anitescu(model::ball_contact_system(ball, random_ball_state(random, 0.001)), 0.1);
    REQUIRE(lcs.F.rows() == 8);
    CHECK(lcs.F == lcs.F.transpose());
    const VectorXd eigenvalues = support::eigenvalues(lcs.F);
    CHECK(eigenvalues.minCoeff() >= -1e-12 * eigenvalues.maxCoeff());
    CHECK(eigenvalues.maxCoeff() > 0.0);
  }
}

TEST_CASE("anitescu: without friction the next state is Stewart and Trinkle's") {
  support::Random random(32);
  const model::BallModelParameters ball{0.01, 0.0195, 0.132, 0.0315, 0.0, 0.0, 0.0};
  const double dt = 0.02;
  int touching = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const scene::Scene at = random_ball_state(random, random.uniform(-0.001, 0.002));
    const model::ContactSystem system = model::ball_contact_system(ball, at);
    const VectorXd x = VectorXd(model::ball_state(at)), u = 0.3 * random.vector(3);
    const lcs::Simulation expected = one_step(model::stewart_trinkle(system, dt), x, u);
    const lcs::Simulation next = one_step(model::anitescu(system, dt), x, u);
    CHECK((next.x - expected.x).norm() < 1e-7);
    // a contact's impulse is the sum of its edges'
    for (int contact = 0; contact < 2; ++contact) {
      const double impulse = next.lambda.col(0).segment<4>(4 * contact).sum();
      CHECK(impulse == Approx(dt * expected.lambda(2 + contact, 0)).margin(1e-7));
      touching += impulse > 1e-6 ? 1 : 0;
    }
    // and so it is where the contacts have no edges
    model::ContactSystem smooth = system;
    smooth.J_t.resize(0, 9);
    const lcs::Lcs edgeless = model::anitescu(smooth, dt);
    REQUIRE(edgeless.F.rows() == 2);
    CHECK((one_step(edgeless, x, u).x - expected.x).norm() < 1e-7);
  }
  CHECK(touching > 20);
}

TEST_CASE("anitescu: the gap follows q_k, so an LCS made elsewhere still finds the ground") {
  // linearised at a height of 1, started at a height of 0.01 with 2 m/s downwards
  const lcs::Lcs lcs = model::anitescu(point_on_plane(Vector3d(0.0, 0.0, 1.0), 0.5), kStep);
  const lcs::Simulation next =
      one_step(lcs, state(Vector3d(0.0, 0.0, 0.01), Vector3d(0.0, 0.0, -2.0)), Vector3d::Zero());
  CHECK(next.x(2, 1) == Approx(0.0).margin(1e-9));
  CHECK(next.x(5, 1) == Approx(-1.0));
}

TEST_CASE("spring contacts: the force is k times the depth at the start of the step, else zero") {
  const double k = 300.0;
  model::ContactSystem system = point_on_plane(Vector3d::Zero(), 0.0);
  const lcs::Lcs lcs = model::spring_contacts(system, VectorXd::Constant(1, k), kStep);
  lcs::check(lcs);
  CHECK(lcs.H.isZero(0.0));
  lcs::Simulation next =
      one_step(lcs, state(Vector3d(0.0, 0.0, -0.02), Vector3d(1.0, 0.0, 0.0)), Vector3d::Zero());
  CHECK(next.lambda(0, 0) == Approx(6.0));
  CHECK(next.x(0, 1) == Approx(kStep));  // explicit: the positions move with the old velocity
  CHECK(next.x(5, 1) == Approx(kStep * (6.0 / kMass - kGravity)));
  next = one_step(lcs, state(Vector3d(0.0, 0.0, 0.02), Vector3d::Zero()), Vector3d::Zero());
  CHECK(next.lambda(0, 0) == 0.0);
}

TEST_CASE("linearise: the Jacobian of a nonlinear f is that of finite differences") {
  support::Random random(33);
  const NonlinearCartPole f;
  for (int trial = 0; trial < 20; ++trial) {
    const VectorXd q = 2.0 * random.vector(2), v = 3.0 * random.vector(2), u = random.vector(1);
    model::ContactSystem system;
    model::linearise(f, q, v, u, system);
    const double h = 1e-6;
    const auto difference = [&](int of, Eigen::Index i) {
      VectorXd at[2][3] = {{q, v, u}, {q, v, u}};
      at[0][of][i] += h;
      at[1][of][i] -= h;
      return VectorXd((f(at[0][0], at[0][1], at[0][2]) - f(at[1][0], at[1][1], at[1][2])) /
                      (2.0 * h));
    };
    for (Eigen::Index i = 0; i < 2; ++i) {
      CHECK((system.J_f_q.col(i) - difference(0, i)).norm() < 1e-6);
      CHECK((system.J_f_v.col(i) - difference(1, i)).norm() < 1e-6);
    }
    CHECK((system.J_f_u.col(0) - difference(2, 0)).norm() < 1e-6);
    CHECK(
        (system.J_f_q * q + system.J_f_v * v + system.J_f_u * u + system.d_v - f(q, v, u)).norm() <
        1e-12);
  }
}

TEST_CASE("linearise: at the upright cart-pole it gives the matrices of the example") {
  const model::ContactSystem expected =
      model::cart_pole_system(model::CartPoleParameters::simulated());
  model::ContactSystem system;
  model::linearise(NonlinearCartPole{}, VectorXd::Zero(2), VectorXd::Zero(2), VectorXd::Zero(1),
                   system);
  CHECK((system.J_f_q - expected.J_f_q).norm() < 1e-12);
  CHECK((system.J_f_v - expected.J_f_v).norm() < 1e-12);
  CHECK((system.J_f_u - expected.J_f_u).norm() < 1e-12);
  CHECK(system.d_v.norm() == 0.0);
}

TEST_CASE("linearise: an f that is constant in some rows, or of a wrong size, is met or refused") {
  const auto falling = [](const auto& q, const auto& v, const auto& u) {
    auto result = v;
    result[0] = -kGravity;
    result[1] = u[0] * q[1];
    return result;
  };
  const VectorXd two = (VectorXd(2) << 3.0, 4.0).finished(), one = VectorXd::Constant(1, 5.0);
  model::ContactSystem system;
  model::linearise(falling, two, two, one, system);
  CHECK(system.J_f_q == (MatrixXd(2, 2) << 0, 0, 0, 5).finished());
  CHECK(system.J_f_v.isZero(0.0));
  CHECK(system.J_f_u == (MatrixXd(2, 1) << 0, 4).finished());
  CHECK(system.d_v == Eigen::Vector2d(-kGravity, -20.0));
  const auto short_one = [](const auto&, const auto&, const auto& u) { return u; };
  CHECK_THROWS_AS(model::linearise(short_one, two, two, one, system), std::invalid_argument);
}
