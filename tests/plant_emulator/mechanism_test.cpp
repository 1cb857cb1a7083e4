#include "plant_emulator/mechanism.hpp"

#include <cmath>
#include <string>

#include <catch2/catch.hpp>

#include "controller/mjcf/error.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::VectorXd;

namespace {

const std::string kPusher = C3RT_SOURCE_DIRECTORY "/examples/pusher/pusher.xml";

}  // namespace

TEST_CASE("mechanism plant: a state is put in and comes out again, at home where nothing is said") {
  plant::Mechanism plant(kPusher, 0.001);
  VectorXd x(16);
  plant.state(x);
  VectorXd home = VectorXd::Zero(16);
  home.segment<3>(2) << 0.1, 0.01, 0.02;
  CHECK((x - home).norm() < 1e-12);
  support::Random random(1);
  for (int i = 0; i < 20; ++i) {
    const VectorXd any = random.vector(16);
    plant.reset(any);
    plant.state(x);
    CHECK((x - any).norm() < 1e-9);
  }
  CHECK_THROWS_WITH(plant.reset(VectorXd::Zero(3)), Catch::Contains("16 finite numbers"));
  CHECK_THROWS_AS(plant::Mechanism("/nowhere.xml", 0.001), mjcf::Error);
}

TEST_CASE(
    "mechanism plant: a force moves the slide as Newton has it, and the floor holds the disc") {
  plant::Mechanism plant(kPusher, 0.001);
  VectorXd x(16);
  // away from the disc: m v̇ = u − d v with 0.5 kg and 1 N s/m
  for (int i = 0; i < 200; ++i) plant.step(Eigen::Vector2d(-2.0, 0.0));
  plant.state(x);
  CHECK(x[8] == Approx(-2.0 * (1.0 - std::exp(-0.4))).epsilon(0.01));
  CHECK(x[4] == Approx(0.02).margin(1e-3));
  CHECK(x.segment<2>(2).isApprox(Eigen::Vector2d(0.1, 0.01), 1e-3));
  plant.reset((VectorXd(16) << 0, 0, 0.1, 0.01, 0.5, VectorXd::Zero(11)).finished());
  for (int i = 0; i < 100; ++i) plant.step(Eigen::Vector2d::Zero());
  plant.state(x);
  CHECK(x[12] == Approx(-0.981).epsilon(1e-6));  // it falls
}
