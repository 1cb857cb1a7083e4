#include "controller/mjcf/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/mjcf_file.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Catch::Contains;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Kind = scene::Coordinate::Kind;

namespace {

/// Two links in the xz-plane, each of a point mass at its end but for a little sphere.
constexpr double kLength1 = 0.4, kLength2 = 0.3, kMass1 = 0.7, kMass2 = 0.5, kArmature = 0.02,
                 kDamping = 0.1, kGear = 2.0;
const std::string kArm = R"(
  <worldbody>
    <body name="upper"><joint name="shoulder" axis="0 1 0"/>
      <geom name="elbow_mass" type="sphere" size="1e-5" pos="0.4 0 0" mass="0.7"/>
      <body name="lower" pos="0.4 0 0"><joint name="elbow" axis="0 1 0" armature="0.02" damping="0.1"/>
        <geom name="hand" type="sphere" size="1e-5" pos="0.3 0 0" mass="0.5"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="elbow_motor" joint="elbow" gear="2" ctrllimited="true" ctrlrange="-3 4"/>
  </actuator>)";

std::string refusal(const std::string& inside) {
  const test::MjcfFile file(inside);
  try {
    (void)mjcf::read_mechanism(file.path());
  } catch (const mjcf::Error& error) {
    return error.what();
  }
  return "accepted";
}

/// M and M f of the two links, from the textbook: angles from the x axis down (about y).
struct Textbook {
  Matrix2d M;
  Vector2d torque;
};
Textbook arm_at(const Vector2d& q, const Vector2d& v, double u) {
  const double c2 = std::cos(q[1]), s2 = std::sin(q[1]);
  const double m1 = kMass1 * kLength1 * kLength1, m2 = kMass2 * kLength2 * kLength2,
               between = kMass2 * kLength1 * kLength2, whole = kMass2 * kLength1 * kLength1;
  Textbook result;
  result.M << m1 + whole + m2 + 2.0 * between * c2, m2 + between * c2, m2 + between * c2,
      m2 + kArmature;
  const Vector2d coriolis(-between * s2 * (2.0 * v[0] * v[1] + v[1] * v[1]),
                          between * s2 * v[0] * v[0]);
  // turning about +y leads down: gravity helps
  const double of_2 = kMass2 * 9.81 * kLength2 * std::cos(q[0] + q[1]);
  const Vector2d gravity((kMass1 + kMass2) * 9.81 * kLength1 * std::cos(q[0]) + of_2, of_2);
  result.torque = gravity - coriolis + Vector2d(0.0, kGear * u - kDamping * v[1]);
  return result;
}

}  // namespace

TEST_CASE("mechanism: mass matrix, bias and inputs of a two-link arm are the textbook's") {
  const test::MjcfFile file(kArm);
  const mjcf::MechanismFile read = mjcf::read_mechanism(file.path());
  support::Random random(1);
  scene::SmoothMotion motion;
  for (int i = 0; i < 50; ++i) {
    const Vector2d q = 3.0 * random.vector(2), v = 4.0 * random.vector(2);
    read.mechanism->evaluate(q, v, motion);
    const Textbook expected = arm_at(q, v, 0.0);
    CHECK((motion.M_inverse * expected.M - Matrix2d::Identity()).norm() < 1e-6);
    CHECK((expected.M * motion.f - expected.torque).norm() < 1e-6);
    CHECK((expected.M * motion.J_u - Vector2d(0.0, kGear)).norm() < 1e-6);
    // the derivatives from differences of the textbook
    constexpr double kStep = 1e-5;
    const auto f = [](const Vector2d& at_q, const Vector2d& at_v) -> Vector2d {
      const Textbook of = arm_at(at_q, at_v, 0.0);
      return of.M.inverse() * of.torque;
    };
    for (int axis = 0; axis < 2; ++axis) {
      const Vector2d by = kStep * Vector2d::Unit(axis);
      const Vector2d of_q = (f(q + by, v) - f(q - by, v)) / (2.0 * kStep);
      const Vector2d of_v = (f(q, v + by) - f(q, v - by)) / (2.0 * kStep);
      CHECK((motion.J_q.col(axis) - of_q).norm() < 1e-5 * (1.0 + of_q.norm()));
      CHECK((motion.J_v.col(axis) - of_v).norm() < 1e-5 * (1.0 + of_v.norm()));
    }
    // where the hand is, and how it moves
    const Vector3d hand(kLength1 * std::cos(q[0]) + kLength2 * std::cos(q[0] + q[1]), 0.0,
                        -kLength1 * std::sin(q[0]) - kLength2 * std::sin(q[0] + q[1]));
    CHECK((read.mechanism->place(2).p - hand).norm() < 1e-12);
    MatrixXd J(3, 2);
    read.mechanism->jacobian(2, hand, J);
    CHECK((J.col(1) -
           Vector3d(-kLength2 * std::sin(q[0] + q[1]), 0.0, -kLength2 * std::cos(q[0] + q[1])))
              .norm() < 1e-12);
  }
}

TEST_CASE(
    "mechanism: a free body falls and turns as Newton and Euler have it, wherever its origin") {
  // the centre of mass is not the origin, nor are the principal axes the body's
  const test::MjcfFile file(R"(<worldbody>
      <body name="hand"><joint name="reach" type="slide" axis="1 0 0"/>
        <geom name="tip" type="sphere" size="0.01" mass="1"/></body>
      <body name="stone" pos="1 0 1" quat="0.9 0.1 -0.3 0.2"><freejoint/>
        <geom name="a" type="box" size="0.1 0.05 0.02" pos="0.1 0.02 0" mass="0.4"/>
        <geom name="b" type="capsule" size="0.02 0.1" pos="0 0 0.1" euler="30 40 0" mass="0.3"/>
      </body></worldbody>
      <actuator><motor joint="reach"/></actuator>)");
  const mjcf::MechanismFile read = mjcf::read_mechanism(file.path());
  scene::Mechanism& mechanism = *read.mechanism;
  REQUIRE(mechanism.n_v() == 7);
  CHECK(mechanism.motors()[0].name == "reach_motor_0");
  CHECK(mechanism.coordinates()[1].name == "stone_x");
  CHECK(mechanism.coordinates()[6].rate == "stone_turn_rate_z");
  CHECK(mechanism.home().tail(3).isZero(1e-12));
  const scene::Object& stone = mechanism.bodies()[2].object;
  CHECK(stone.mass == Approx(0.7));
  CHECK_FALSE(mechanism.bodies()[2].driven);
  CHECK(mechanism.bodies()[1].driven);
  const Eigen::Matrix3d R_home = [&] {
    scene::SmoothMotion motion;
    mechanism.evaluate(mechanism.home(), VectorXd::Zero(7), motion);
    return mechanism.place(2).R;
  }();
  support::Random random(3);
  scene::SmoothMotion motion;
  for (int i = 0; i < 30; ++i) {
    const VectorXd q = mechanism.home() + 0.8 * random.vector(7), v = 3.0 * random.vector(7);
    mechanism.evaluate(q, v, motion);
    const scene::Place place = mechanism.place(2);
    CHECK((place.p - q.segment<3>(1)).norm() < 1e-12);
    CHECK((place.R - scene::rotation(q.segment<3>(4)) * R_home).norm() < 1e-12);
    const Eigen::Matrix3d inertia = place.R * stone.inertia * place.R.transpose();
    const Vector3d omega = v.segment<3>(4);
    CHECK((motion.f.segment<3>(1) - Vector3d(0.0, 0.0, -9.81)).norm() < 1e-9);
    CHECK((inertia * motion.f.segment<3>(4) + omega.cross(inertia * omega)).norm() < 1e-9);
    MatrixXd M = MatrixXd::Identity(7, 7);
    M.block<3, 3>(1, 1) *= 0.7;
    M.block<3, 3>(4, 4) = inertia;
    CHECK((motion.M_inverse * M - MatrixXd::Identity(7, 7)).norm() < 1e-9);
    CHECK((motion.N_q_inverse * motion.N_q - MatrixXd::Identity(7, 7)).norm() < 1e-9);
    // a point of it
    const Vector3d arm = random.vector(3);
    MatrixXd J(3, 7);
    mechanism.jacobian(2, place.p + arm, J);
    CHECK((J * v - v.segment<3>(1) - omega.cross(arm)).norm() < 1e-9);
  }
}

TEST_CASE("mechanism: after the first evaluation none takes from the heap") {
  const test::MjcfFile file(kArm);
  const mjcf::MechanismFile read = mjcf::read_mechanism(file.path());
  scene::SmoothMotion motion;
  VectorXd q = VectorXd::Constant(2, 0.3), v = VectorXd::Constant(2, -0.2);
  MatrixXd J(3, 2);
  read.mechanism->evaluate(q, v, motion);
  std::int64_t calls = 0;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 10; ++i) {
      read.mechanism->evaluate(q, v, motion);
      read.mechanism->jacobian(2, Vector3d::UnitX(), J);
    }
    calls = heap.count();
  }
  CHECK(calls == 0);
}

TEST_CASE("mechanism: the range of a motor, a keyframe as home and joint limits are told") {
  const test::MjcfFile file(kArm + "<keyframe><key name=\"bent\" qpos=\"0.5 -0.25\"/></keyframe>");
  const mjcf::MechanismFile read = mjcf::read_mechanism(file.path());
  CHECK(read.mechanism->home() == Vector2d(0.5, -0.25));
  CHECK(read.mechanism->motors()[0].min == -3.0);
  CHECK(read.mechanism->motors()[0].max == 4.0);
  CHECK(read.mechanism->motors()[0].turns);
  const auto has = [](const mjcf::MechanismFile& of, const std::string& words) {
    return std::any_of(of.notes.begin(), of.notes.end(), [&](const std::string& note) {
      return note.find(words) != std::string::npos;
    });
  };
  CHECK(has(read, "keyframe \"bent\""));
  std::string limited = kArm;
  limited.replace(limited.find("name=\"elbow\""), 12,
                  "name=\"elbow\" limited=\"true\" range=\"-90 90\"");
  const test::MjcfFile with_limits(limited);
  CHECK(has(mjcf::read_mechanism(with_limits.path()), "joint \"elbow\" has limits"));
}

TEST_CASE("mechanism: what no plan knows of is refused by its name") {
  const std::string body = R"(<worldbody><body name="arm"><joint name="pin"/>
      <geom name="bar" size="0.1" mass="1"/><site name="end"/></body>)";
  const std::string motor = "<actuator><motor joint=\"pin\"/></actuator>";
  CHECK(refusal(body + "</worldbody>" + motor) == "accepted");
  CHECK_THAT(refusal(body + "</worldbody>"), Contains("expected at least one motor"));
  CHECK_THAT(
      refusal(body + "</worldbody><actuator><position name=\"servo\" joint=\"pin\"/></actuator>"),
      Contains("thing.xml: expected motors") && Contains("\"servo\""));
  CHECK_THAT(refusal(body + "</worldbody><actuator><general name=\"slow\" joint=\"pin\" "
                            "dyntype=\"integrator\"/></actuator>"),
             Contains("\"slow\""));
  CHECK_THAT(refusal(body + "</worldbody><actuator><motor name=\"jet\" site=\"end\"/></actuator>"),
             Contains("\"jet\", which is at no joint"));
  CHECK_THAT(
      refusal(body + "</worldbody>" + motor +
              "<tendon><fixed name=\"rope\"><joint joint=\"pin\" coef=\"1\"/></fixed></tendon>"),
      Contains("the tendon \"rope\""));
  CHECK_THAT(refusal(body + "</worldbody>" + motor +
                     "<equality><joint name=\"lock\" joint1=\"pin\"/></equality>"),
             Contains("the equality \"lock\""));
  CHECK_THAT(refusal(body +
                     "<body><joint name=\"all_ways\" type=\"ball\"/><geom size=\"0.1\"/></body>"
                     "</worldbody>" +
                     motor),
             Contains("a ball joint, \"all_ways\""));
  CHECK_THAT(refusal(body +
                     "<body><joint name=\"rusty\" frictionloss=\"1\"/><geom size=\"0.1\"/></body>"
                     "</worldbody>" +
                     motor),
             Contains("frictionloss of joint \"rusty\""));
  CHECK_THAT(
      refusal("<asset><hfield name=\"hills\" nrow=\"2\" ncol=\"2\" size=\"1 1 1 1\"/></asset>" +
              body + "<geom name=\"hill\" type=\"hfield\" hfield=\"hills\"/></worldbody>" + motor),
      Contains("geom \"hill\", which is a height field"));
  CHECK_THAT(
      refusal(body + "<geom name=\"egg\" type=\"ellipsoid\" size=\"1 2 3\"/></worldbody>" + motor),
      Contains("geom \"egg\", which is an ellipsoid"));
  CHECK_THAT(
      refusal(body + "<body name=\"ghost\" mocap=\"true\"><geom size=\"0.1\"/></body></worldbody>" +
              motor),
      Contains("the mocap body \"ghost\""));
  CHECK_THAT(refusal("<nonsense/>"), Contains("a model that MuJoCo can read"));
}
