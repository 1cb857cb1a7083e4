#include "controller/impedance/law.hpp"

#include <array>
#include <cmath>
#include <random>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/panda.hpp"

using namespace c3rt;
using namespace c3rt::impedance;

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kStiffness = 500, kDamping = 44.72, kStiffnessRotation = 900,
                 kDampingRotation = 42.43;

const Vector7d kStart = (Vector7d() << 0, 0.275, 0, -2.222, 0, 2.497, 0).finished();

Gains paper_gains() {
  Gains gains;
  gains.stiffness << kStiffness, kStiffness, kStiffness, kStiffnessRotation, kStiffnessRotation,
      kStiffnessRotation;
  gains.damping << kDamping, kDamping, kDamping, kDampingRotation, kDampingRotation,
      kDampingRotation;
  gains.null_space_stiffness = 4;
  gains.null_space_damping = 4;
  gains.null_space_q << 0, 0.361, 0, -2.223, 0, 2.584, 0;
  return gains;
}

class Postures {
 public:
  /// Around the start posture, far from singularities.
  Vector7d q() { return kStart + 0.4 * noise(); }
  Vector7d noise() {
    return Vector7d::NullaryExpr([&] { return unit_(generator_); });
  }

 private:
  std::mt19937 generator_{11};
  std::uniform_real_distribution<double> unit_{-1, 1};
};

Goal goal_at(const Eigen::Isometry3d& X_WE) {
  return {X_WE.translation(), Vector3d::Zero(), Quaterniond(X_WE.linear()), Vector3d::Zero()};
}

/// Joint accelerations of the arm under a torque that the robot adds its gravity compensation to.
Vector7d acceleration(const ArmState& arm, const Vector7d& tau) {
  return support::solve_definite(arm.M, tau - arm.coriolis);
}

TEST_CASE(
    "law: the end effector accelerates by K e + B e', whatever the posture and the null-space "
    "torque") {
  model::Arm arm(test::panda_arm());
  Postures random;
  ArmState state;
  const Gains gains = paper_gains();
  for (int n = 0; n < 50; ++n) {
    const Vector7d q = random.q(), dq = random.noise();
    arm.update(q, dq, state);
    Goal goal = goal_at(state.X_WE);
    goal.p_WE += 0.02 * random.noise().head<3>();
    goal.v_WE = random.noise().head<3>();
    goal.q_WE =
        Quaterniond(Eigen::AngleAxisd(0.3, random.noise().head<3>().normalized())) * goal.q_WE;

    Vector6d e_dot = -state.V_WE;
    e_dot.head<3>() += goal.v_WE;
    const Vector6d expected =
        gains.stiffness.cwiseProduct(pose_error(state.X_WE, goal.p_WE, goal.q_WE)) +
        gains.damping.cwiseProduct(e_dot);
    const Vector6d achieved =
        state.J_WE * acceleration(state, torque(gains, state, q, dq, goal).sum());
    CHECK((achieved - expected).norm() < 1e-9 * (1 + expected.norm()));
  }
}

TEST_CASE("law: a small error dies out as e'' + B e' + K e = 0 says") {
  // critically damped in translation: e(t) = e_0 (1 + w t) exp(-w t) with w = B/2; 1 mm keeps the
  // terms of second order (J' dq, which (36) leaves out) below 1 % of e_0
  model::Arm arm(test::panda_arm());
  ArmState state;
  const Gains gains = paper_gains();
  Vector7d q = gains.null_space_q, dq = Vector7d::Zero();
  arm.update(q, dq, state);
  Goal goal = goal_at(state.X_WE);
  const Vector3d e_0(1e-3, -0.6e-3, 0.8e-3);
  goal.p_WE += e_0;
  constexpr double kDt = 1e-4, kOmega = kDamping / 2;
  for (int n = 1; n <= 3000; ++n) {
    // explicit midpoint: second order in kDt
    const Vector7d ddq = acceleration(state, torque(gains, state, q, dq, goal).sum());
    const Vector7d q_half = q + 0.5 * kDt * dq, dq_half = dq + 0.5 * kDt * ddq;
    arm.update(q_half, dq_half, state);
    const Vector7d ddq_half =
        acceleration(state, torque(gains, state, q_half, dq_half, goal).sum());
    q += kDt * dq_half;
    dq += kDt * ddq_half;
    arm.update(q, dq, state);
    const double t = n * kDt;
    const Vector3d expected = e_0 * ((1 + kOmega * t) * std::exp(-kOmega * t));
    const Vector6d e = pose_error(state.X_WE, goal.p_WE, goal.q_WE);
    REQUIRE((e.head<3>() - expected).norm() < 0.01 * e_0.norm());
    REQUIRE(e.tail<3>().norm() < 1e-5);
  }
}

TEST_CASE("law: a small rotation dies out with half the rotational stiffness") {
  // the vector part of a quaternion is half the angle: a'' + B a' + K/2 a = 0, here critically
  // damped
  model::Arm arm(test::panda_arm());
  ArmState state;
  const Gains gains = paper_gains();
  Vector7d q = gains.null_space_q, dq = Vector7d::Zero();
  arm.update(q, dq, state);
  Goal goal = goal_at(state.X_WE);
  constexpr double kAngle = 2e-3;
  goal.q_WE = Quaterniond(Eigen::AngleAxisd(kAngle, Vector3d(0.6, 0.8, 0))) * goal.q_WE;
  constexpr double kDt = 1e-4;
  const double omega = std::sqrt(kStiffnessRotation / 2);
  for (int n = 1; n <= 2000; ++n) {
    const Vector7d ddq = acceleration(state, torque(gains, state, q, dq, goal).sum());
    dq += kDt * ddq;  // semi-implicit Euler: of first order, hence the tolerance
    q += kDt * dq;
    arm.update(q, dq, state);
    const double t = n * kDt;
    const double angle = Quaterniond(state.X_WE.linear()).angularDistance(goal.q_WE);
    REQUIRE(angle == Approx(kAngle * (1 + omega * t) * std::exp(-omega * t)).margin(0.01 * kAngle));
  }
}

TEST_CASE("law: null-space torque moves the joints and not the end effector") {
  model::Arm arm(test::panda_arm());
  Postures random;
  ArmState state;
  for (int n = 0; n < 50; ++n) {
    arm.update(random.q(), Vector7d::Zero(), state);
    const Matrix7d N = task_inertia(state).N;
    const Vector7d ddq = support::solve_definite(state.M, N * (10 * random.noise()));
    CHECK((state.J_WE * ddq).norm() < 1e-10);
    CHECK(ddq.norm() > 1e-2);  // one direction is left: the elbow's
    CHECK((N * N - N).norm() < 1e-9);
  }
}

/// At the goal's pose and without K_n only the damping acts beside C_f, which is no damping and is
/// taken out.
double damping_power(const Gains& gains, const ArmState& state, const Vector7d& q,
                     const Vector7d& dq) {
  return dq.dot(torque(gains, state, q, dq, goal_at(state.X_WE)).sum() - state.coriolis);
}

TEST_CASE("law: the task's damping never feeds energy into the arm") {
  model::Arm arm(test::panda_arm());
  Postures random;
  ArmState state;
  Gains gains = paper_gains();
  gains.null_space_stiffness = 0;
  gains.null_space_damping = 0;
  for (int n = 0; n < 200; ++n) {
    gains.inertia = std::array{Inertia::kFull, Inertia::kDiagonal,
                               Inertia::kUncoupled}[static_cast<std::size_t>(n % 3)];
    const Vector7d q = random.q(), dq = random.noise();
    arm.update(q, dq, state);
    CHECK(damping_power(gains, state, q, dq) < 0.0);
  }
}

TEST_CASE(
    "law: an end effector that is held up in z is pushed sideways by the full inertia, not by the "
    "diagonal") {
  // the wrench w with tau = J^T w, at rest and without posture: J M^-1 tau = (J M^-1 J^T) w
  model::Arm arm(test::panda_arm());
  ArmState state;
  Gains gains = paper_gains();
  gains.null_space_stiffness = 0;
  arm.update(kStart, Vector7d::Zero(), state);
  Goal goal = goal_at(state.X_WE);
  goal.p_WE.z() -= 0.001;
  const auto wrench = [&](Inertia inertia) {
    gains.inertia = inertia;
    const Vector7d tau = torque(gains, state, kStart, Vector7d::Zero(), goal).sum();
    return Vector6d(task_inertia(state).Lambda * state.J_WE *
                    support::solve_definite(state.M, tau));
  };
  const Vector6d diagonal = wrench(Inertia::kDiagonal), full = wrench(Inertia::kFull);
  CHECK(diagonal.z() < -1.0);
  Vector6d others = diagonal;
  others[2] = 0.0;
  CHECK(others.norm() < 1e-9);
  CHECK(full.z() == Approx(diagonal.z()));
  CHECK(full.x() > 0.3 * std::abs(full.z()));  // what pushed the ball away from the robot
}

TEST_CASE("law: with the uncoupled inertia a blocked end effector is pushed only back") {
  model::Arm arm(test::panda_arm());
  ArmState state;
  arm.update(kStart, Vector7d::Zero(), state);
  const Matrix6d Lambda = task_inertia(state).Lambda, W = uncoupled(Lambda);
  CHECK((W - W.transpose()).norm() < 1e-12);
  CHECK(support::is_definite(W));
  // z is held 1 mm off and the rotation has settled where it feels no moment: the rotational part
  // of the acceleration a asked for is such that (W a)_r = 0
  for (int axis = 0; axis < 3; ++axis) {
    Vector6d a = Vector6d::Zero();
    a[axis] = 1.0;
    a.tail<3>() = -W.bottomRightCorner<3, 3>().inverse() * W.bottomLeftCorner<3, 3>() * a.head<3>();
    Vector6d wrench = W * a;
    CHECK(wrench[axis] > 0.0);
    wrench[axis] = 0.0;
    CHECK(wrench.norm() < 1e-9);
  }
  // and no direction is stiffened by more than three
  const Eigen::VectorXd gain = support::eigenvalues(W, Lambda);
  CHECK(gain.maxCoeff() < 3.0);
  CHECK(gain.minCoeff() > 0.5);
}

TEST_CASE(
    "law: the null-space damping slows every motion that leaves the end effector where it is") {
  model::Arm arm(test::panda_arm());
  Postures random;
  ArmState state;
  Gains gains = paper_gains();
  gains.null_space_stiffness = 0;
  for (int n = 0; n < 200; ++n) {
    const Vector7d q = random.q();
    arm.update(q, Vector7d::Zero(), state);
    const Vector7d dq = task_inertia(state).N.transpose() * random.noise();
    arm.update(q, dq, state);
    REQUIRE(state.V_WE.norm() < 1e-9);
    CHECK(damping_power(gains, state, q, dq) ==
          Approx(-gains.null_space_damping * dq.squaredNorm()));
  }
}

TEST_CASE(
    "law: with the planned contact force present, feed-forward keeps the end effector at rest") {
  // statics: M ddq = tau + J_v^T f = 0 at the goal
  model::Arm arm(test::panda_arm());
  ArmState state;
  Gains gains = paper_gains();
  const Vector7d q = gains.null_space_q;
  arm.update(q, Vector7d::Zero(), state);
  const Vector3d force(3, -2, 5);
  const Vector7d contact = state.J_WE.topRows<3>().transpose() * force;

  Goal goal = goal_at(state.X_WE);
  const Vector7d without = torque(gains, state, q, Vector7d::Zero(), goal).sum() + contact;
  CHECK((state.J_WE * acceleration(state, without)).head<3>().dot(force) >
        0.1);  // it is pushed back

  goal.force_E = force;
  const Vector7d with = torque(gains, state, q, Vector7d::Zero(), goal).sum() + contact;
  CHECK(acceleration(state, with).norm() < 1e-10);
}

TEST_CASE("law: the rotational error goes the short way and is expressed in the world") {
  const Eigen::Isometry3d X_WE(Eigen::AngleAxisd(2.0, Vector3d(1, 2, 3).normalized()));
  const Vector3d axis = Vector3d(-1, 1, 2).normalized();
  const Quaterniond turned = Quaterniond(Eigen::AngleAxisd(0.4, axis)) * Quaterniond(X_WE.linear());
  const Quaterniond same(-turned.w(), -turned.x(), -turned.y(), -turned.z());
  for (const Quaterniond& desired : {turned, same}) {
    const Vector6d e = pose_error(X_WE, Vector3d(1, 2, 3), desired);
    CHECK((e.head<3>() - Vector3d(1, 2, 3)).norm() < 1e-15);
    CHECK((e.tail<3>() - std::sin(0.2) * axis).norm() < 1e-12);
  }
}

TEST_CASE("law: a stretched arm asks for bounded torque") {
  // joint 4 at 0: the arm is straight and cannot move along itself
  model::Arm arm(test::panda_arm());
  ArmState state;
  const Vector7d q = (Vector7d() << 0.1, 0.4, -0.2, 0.0, 0.3, 0.5, 0.1).finished();
  arm.update(q, Vector7d::Zero(), state);
  const TaskInertia task = task_inertia(state);
  CHECK(task.Lambda.allFinite());
  CHECK(support::eigenvalues(task.Lambda).maxCoeff() <= 1.0001 / kSmallestMobility);
  Goal goal = goal_at(state.X_WE);
  goal.p_WE *= 1.05;
  CHECK(torque(paper_gains(), state, q, Vector7d::Zero(), goal).sum().norm() < 2000);
}

TEST_CASE("law: in the task's space nothing is bounded, so the law is exact there") {
  model::Arm arm(test::panda_arm());
  Postures random;
  ArmState state;
  for (int n = 0; n < 200; ++n) {
    arm.update(random.q(), Vector7d::Zero(), state);
    const Matrix6d mobility = state.J_WE * support::solve_definite(state.M, state.J_WE.transpose());
    CHECK((task_inertia(state).Lambda * mobility - Matrix6d::Identity()).norm() < 1e-9);
  }
}

TEST_CASE("law: torque does not allocate") {
  model::Arm arm(test::panda_arm());
  ArmState state;
  arm.update(kStart, Vector7d::Ones(), state);
  const Gains gains = paper_gains();
  const Goal goal = goal_at(state.X_WE);
  Vector7d sum = Vector7d::Zero();
  std::int64_t heap_calls = 0;
  {
    const support::AllocationCounter heap;
    for (int n = 0; n < 100; ++n) sum += torque(gains, state, kStart, Vector7d::Ones(), goal).sum();
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
  CHECK(sum.allFinite());
}

}  // namespace
