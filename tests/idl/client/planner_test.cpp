#include "idl/client/planner.hpp"

#include <functional>
#include <string>

#include <catch2/catch.hpp>

#include "idl/endpoint.hpp"
#include "tests/idl/bus_fixture.hpp"

using namespace c3rt;
using namespace c3rt::client;
namespace test = c3rt::wire::test;

namespace {

using wire::ClockMode;

class Still : public Planner {
 public:
  using Planner::Planner;
  Motion plan(const Situation& now) override { return {{{now.effector.p}}}; }
};

/// One of the processes, in service until it is killed.
int serve(wire::Process process) {
  wire::Bus bus(test::settings(ClockMode::kRealtime, 7));
  wire::Endpoint endpoint(bus, process, {}, {});
  endpoint.say(c3rt_v2_SERVICE_RUNNING, "here");
  while (true) pause();
}

/// A plant in lockstep that waits for somebody who does not come.
int wait_in_lockstep() {
  wire::Bus bus(test::settings(ClockMode::kLockstep, 7));
  wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_PLANT, {}, {});
  const wire::LockstepMaster master(bus, {c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION},
                                    600 * test::kSecond);
  return 0;
}

template <typename Error>
std::string ends(ClockMode clock) {
  try {
    Still().run({test::kDomain, "loopback", clock, 0});
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

}  // namespace

TEST_CASE("planner: in the other clock than the plant it ends and names both") {
  {
    const test::Child plant([] { return serve(c3rt_v2_PROCESS_PLANT); });
    CHECK_THAT(ends<WrongClock>(ClockMode::kLockstep),
               Catch::StartsWith("the run is in realtime, this planner in lockstep"));
  }
  const test::Child plant(wait_in_lockstep);
  CHECK_THAT(ends<WrongClock>(ClockMode::kRealtime),
             Catch::StartsWith("the run is in lockstep, this planner in realtime"));
}

TEST_CASE("planner: where there is one already it ends and names it") {
  const test::Child other([] { return serve(c3rt_v2_PROCESS_PLANNER); });
  CHECK_THAT(ends<Occupied>(ClockMode::kLockstep),
             Catch::StartsWith("domain " + std::to_string(test::kDomain) +
                               " has a planner already (pid " + std::to_string(other.pid()) + ")"));
}

TEST_CASE("planner: a setting or a word that cannot be is named with what is expected") {
  const auto refused = [](const PlannerSettings& settings) -> std::string {
    try {
      const Still planner(settings);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refused({0.5}) == "rate: expected 1 to 1000, got 0.5");
  CHECK(refused({20.0, -1.0}) == "delay: expected 0 to 1, got -1");
  CHECK(refused({20.0, 0.0, 11.0}) == "valid_for: expected 0.001 to 10, got 11");
  for (std::vector<std::string> words : {std::vector<std::string>{"mine", "--clock", "lockstp"},
                                         {"mine", "--domain=x"},
                                         {"mine", "--session"},
                                         {"mine", "--rate", "3"},
                                         {"mine", "--domain", "231"}}) {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    CHECK(Still().main(static_cast<int>(argv.size()), argv.data()) == 2);
  }
}
