#include "idl/client/estimator.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

#include "idl/endpoint.hpp"
#include "idl/validate.hpp"
#include "tests/idl/bus_fixture.hpp"

using namespace c3rt;
using namespace c3rt::client;
namespace test = c3rt::wire::test;

namespace {

class Blind : public Estimator {
 public:
  using Estimator::Estimator;
  std::vector<Estimate> estimate(double, const wire::Scene*) override { return {}; }
};

std::string refusal_of(const Estimate& estimate) {
  try {
    estimate_sample(estimate, 1);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE(
    "estimator: an estimate is a sample that every reader lets in, its quaternion of norm 1") {
  const wire::ObjectEstimate sample = estimate_sample(
      {2, {0.5, -0.1, 0.007}, {0, 0, 3, 4}, {0.1, 0, 0}, {0, 0, 2}, true, "ball"}, 5'000'000);
  CHECK_FALSE(wire::validate(sample));
  CHECK(sample.object_index == 2);
  CHECK(std::string(sample.name) == "ball");
  CHECK(sample.exposure_ns == 5'000'000);
  CHECK(sample.sensors_used == 1);
  CHECK(sample.p_WB_m[1] == -0.1);
  CHECK(sample.p_measured_m[1] == -0.1);
  CHECK(sample.q_WB[2] == 0.6);
  CHECK(sample.q_WB[3] == 0.8);
  CHECK(sample.omega_rad_per_s[2] == 2.0);
  CHECK(estimate_sample({0, {}, {1, 0, 0, 0}, {}, {}, false}, 5).sensors_used == 0);
}

TEST_CASE("estimator: what no reader would let in is named") {
  CHECK(refusal_of({8}) == "index: expected 0 to 7, got 8");
  CHECK(refusal_of({-1}) == "index: expected 0 to 7, got -1");
  CHECK_THAT(refusal_of({0, {}, {0, 0, 0, 0}}), Catch::Contains("q_"));
  CHECK_THAT(refusal_of({0, {std::nan(""), 0, 0}}), Catch::Contains("p_"));
  CHECK_THAT(refusal_of({0, {}, {1, 0, 0, 0}, {std::numeric_limits<double>::infinity(), 0, 0}}),
             Catch::Contains("v_WB_m_per_s"));
  CHECK_THAT(refusal_of({0, {}, {1, 0, 0, 0}, {}, {}, true, std::string(32, 'x')}),
             Catch::StartsWith("name: expected at most 31 bytes"));
}

TEST_CASE("estimator: a setting that cannot be is named with what is expected") {
  const auto refused = [](const EstimatorSettings& settings) -> std::string {
    try {
      const Blind estimator(settings);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refused({0.0}) == "rate: expected 1 to 1000, got 0");
  CHECK(refused({80.0, true, 2.0}) == "latency: expected 0 to 1, got 2");
}

TEST_CASE("estimator: where vision is already it ends and names it") {
  const test::Child other([] {
    wire::Bus bus(test::settings(wire::ClockMode::kRealtime, 7));
    wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_VISION, {}, {});
    endpoint.say(c3rt_v2_SERVICE_RUNNING, "here");
    while (true) pause();
    return 0;
  });
  std::string said;
  try {
    Blind().run({test::kDomain, "loopback", wire::ClockMode::kRealtime, 0});
  } catch (const Occupied& error) {
    said = error.what();
  }
  CHECK_THAT(said, Catch::StartsWith("domain " + std::to_string(test::kDomain) +
                                     " has an estimator already (pid " +
                                     std::to_string(other.pid()) + ")"));
}
