#include "idl/client/mover.hpp"

#include <cmath>
#include <string>
#include <variant>

#include <catch2/catch.hpp>

#include "idl/endpoint.hpp"
#include "idl/validate.hpp"
#include "tests/idl/bus_fixture.hpp"

using namespace c3rt;
using namespace c3rt::client;
namespace test = c3rt::wire::test;

namespace {

class Resting : public Mover {
 public:
  std::optional<Command> move(double, const Effector&) override { return std::nullopt; }
};

std::string refusal_of(const Command& command) {
  try {
    motion_sample(command, 1);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("mover: a command is a sample that every reader lets in, of its kind's values alone") {
  JointPositions positions{{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, true};
  wire::RobotMotion sample = motion_sample(positions, 7'000'000);
  CHECK_FALSE(wire::validate(sample));
  CHECK(sample.kind == c3rt_v2_MOTION_JOINT_POSITION);
  CHECK(sample.origin.state_ns == 7'000'000);
  CHECK(sample.q_rad[6] == 0.6);
  CHECK(sample.dq_rad_per_s[6] == 0.0);
  CHECK(sample.finished);

  sample = motion_sample(JointVelocities{{0, 0, 0, 0, 0, 0, -0.2}}, 1);
  CHECK_FALSE(wire::validate(sample));
  CHECK(sample.kind == c3rt_v2_MOTION_JOINT_VELOCITY);
  CHECK(sample.dq_rad_per_s[6] == -0.2);
  CHECK_FALSE(sample.finished);

  CartesianPose pose{{0.5, 0.1, 0.2}, {0, 3, 4, 0}};
  sample = motion_sample(pose, 1);
  CHECK_FALSE(wire::validate(sample));
  CHECK(sample.kind == c3rt_v2_MOTION_CARTESIAN_POSE);
  CHECK(sample.p_WE_m[2] == 0.2);
  CHECK(sample.q_WE[1] == 0.6);
  CHECK(sample.q_WE[2] == 0.8);
  CHECK_FALSE(sample.has_elbow);
  pose.elbow = Elbow{0.4, -1.0};
  sample = motion_sample(pose, 1);
  CHECK(sample.has_elbow);
  CHECK(sample.elbow_q3_rad == 0.4);
  CHECK(sample.elbow_sign == -1.0);

  sample = motion_sample(CartesianVelocities{{0, 0.1, 0}, {0, 0, 0.5}}, 1);
  CHECK_FALSE(wire::validate(sample));
  CHECK(sample.kind == c3rt_v2_MOTION_CARTESIAN_VELOCITY);
  CHECK(sample.v_WE_m_per_s[1] == 0.1);
  CHECK(sample.omega_WE_rad_per_s[2] == 0.5);
}

TEST_CASE("mover: what no reader would let in is named") {
  CHECK_THAT(refusal_of(JointPositions{{std::nan(""), 0, 0, 0, 0, 0, 0}}),
             Catch::Contains("q_rad"));
  CHECK_THAT(refusal_of(CartesianPose{{0.5, 0, 0.1}, {0, 0, 0, 0}}), Catch::Contains("q_WE"));
  CartesianPose pose{{0.5, 0, 0.1}};
  pose.elbow = Elbow{0.0, 1.5};
  CHECK_THAT(refusal_of(pose), Catch::Contains("elbow_sign"));
  pose.elbow = Elbow{0.0, 0.5};
  CHECK_THAT(refusal_of(pose), Catch::Contains("|elbow_sign| is 0.5, expected 1"));
}

TEST_CASE("mover: where impedance is already it ends and names it") {
  const test::Child other([] {
    wire::Bus bus(test::settings(wire::ClockMode::kRealtime, 7));
    wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_IMPEDANCE, {}, {});
    endpoint.say(c3rt_v2_SERVICE_RUNNING, "here");
    while (true) pause();
    return 0;
  });
  std::string said;
  try {
    Resting().run({test::kDomain, "loopback", wire::ClockMode::kRealtime, 0});
  } catch (const Occupied& error) {
    said = error.what();
  }
  CHECK_THAT(said, Catch::StartsWith("domain " + std::to_string(test::kDomain) +
                                     " has a motion generator already (pid " +
                                     std::to_string(other.pid()) + ")"));
}
