// c3rt replay as a person meets it, on recordings that c3rt run leaves.
#include <filesystem>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "cli/lock.hpp"
#include "cli/recording/recording.hpp"
#include "idl/dds.hpp"
#include "tests/cli/folder.hpp"
#include "tests/cli/place.hpp"
#include "tests/idl/bus_fixture.hpp"
#include "tests/idl/samples.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli;
using Catch::Contains;
using support::Outcome;

/// A short run in simulated time.
struct Run {
  explicit Run(const std::string& arguments) {
    const Outcome run = place.c3rt("run " + arguments + " --in-process --no-pictures --out '" +
                                   place.out().string() + "'");
    CAPTURE(run.output);
    REQUIRE(std::filesystem::exists(file()));
  }
  std::filesystem::path file() const { return place.out() / kRecordingName; }
  Outcome replay(const std::string& arguments) const {
    return place.c3rt("replay '" + file().string() + "' " + arguments);
  }
  Place place;
};

}  // namespace

TEST_CASE("an unchanged build gives the recorded answers again, to the bit") {
  const Run run("circle_slow --duration 1.5 --seed 4");
  for (const char* process : {"planner", "vision", "impedance"}) {
    CAPTURE(process);
    const Outcome outcome = run.replay(std::string("--compare ") + process);
    CAPTURE(outcome.output);
    CHECK(outcome.status == 0);
    CHECK_THAT(outcome.output, Contains("every answer is the same to the bit"));
  }
}

TEST_CASE(
    "another setting, and another seed of the noise, show in what and how far answers differ") {
  // long enough to come to the ball, where C3 begins
  const Run run("circle_fast --duration 2.5");
  const Outcome weights = run.replay("--compare planner --set planner.c3.admm_iterations=3");
  CAPTURE(weights.output);
  CHECK(weights.status == 1);
  CHECK_THAT(weights.output, Contains("the first that is not the same: plan ") &&
                                 Contains("recorded") && Contains("given") &&
                                 Contains("largest difference"));
  // an answer says when it takes effect
  const Outcome later = run.replay("--compare planner --set planner.publish_delay_s=0.0085");
  CHECK(later.status == 1);
  CHECK_THAT(later.output, Contains("header.time_ns") && Contains("1e+06"));
  const Outcome noise = run.replay("--compare vision --seed 2");
  CHECK(noise.status == 1);
  CHECK_THAT(noise.output, Contains("p_measured_m"));
  // half as many answers
  const Outcome rate = run.replay("--compare planner --set planner.rate_hz=37.5");
  CHECK(rate.status == 1);
  CHECK_THAT(rate.output, Contains("in the recording alone"));
}

TEST_CASE("who looks at a replay learns what the run was told to override") {
  const Run run("circle_slow --duration 0.2 --seed 4 --set vision.emulated.noise_m=0.002");
  const std::uint32_t domain = wire::test::kDomain;
  const Outcome outcome = run.replay("--rate max --domain " + std::to_string(domain));
  CAPTURE(outcome.output);
  REQUIRE(outcome.status == 0);
  const auto left = last_instance(run.place.locks(), domain);
  REQUIRE(left);
  CHECK(left->verb == "replay");
  CHECK(left->seed == 4);
  CHECK(left->overrides ==
        std::vector<std::string>{"vision.emulated.noise_m=0.002", "task.duration_s=0.2"});
  CHECK(std::filesystem::path(left->file).filename() == "circle_slow.yaml");
}

TEST_CASE("what cannot be replayed is a usage error in a plain sentence") {
  const Folder folder;
  const auto file = folder.path() / "states.mcap";
  {
    Recording recording(file);
    auto state = wire::test::plain<wire::RobotState>();
    state.header = {7, 1, 1'000'000};
    recording.add(state);
    recording.finish();
  }
  const Place place;
  const std::string of = "replay '" + file.string() + "' ";
  for (const auto& [arguments, said] : std::map<std::string, std::string>{
           {"replay /nowhere.mcap", "/nowhere.mcap"},
           {"replay /dev/null", "does not begin as an MCAP"},
           {of + "--topics plann", "unknown topic \"plann\""},
           {of + "--topics plan", "has no plan; it has robot/state"},
           {of + "--compare planner", "does not tell its scenario"},
           {of + "--compare planner --scenario circle_slow", "has no answers of the planner"},
           {of + "--compare impedance --scenario circle_slow", "of a recording in lockstep alone"},
           {of + "--compare plant", "one of planner, vision, impedance"},
           {of + "--rate -1", "a number from 0.01 to 1000, 0 or max"},
           {of + "--rate nan", "a number from 0.01 to 1000, 0 or max"},
           {of + "--set planner.rate_hz=3", "--set requires --compare"},
           {of + "--compare planner --domain 3", "--compare excludes --domain"}}) {
    CAPTURE(arguments);
    const Outcome outcome = place.c3rt(arguments);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains(said));
  }
}

TEST_CASE("a topic that somebody writes is refused when it is named, else left out") {
  const Folder folder;
  const auto file = folder.path() / "short.mcap";
  {
    Recording recording(file);
    for (std::uint64_t i = 1; i <= 20; ++i) {
      auto state = wire::test::plain<wire::RobotState>();
      state.header = {7, i, static_cast<std::int64_t>(1'000'000 * i)};
      recording.add(state);
      auto estimate = wire::test::plain<wire::ObjectEstimate>();
      estimate.header = state.header;
      estimate.exposure_ns = estimate.header.time_ns - 500'000;
      recording.add(estimate);
    }
    recording.finish();
  }
  const Place place;
  const std::string command =
      "replay '" + file.string() + "' --domain " + std::to_string(wire::test::kDomain);
  wire::BusSettings settings = wire::test::settings();
  wire::Bus bus(settings);
  wire::Reader<wire::ObjectEstimate> estimates(bus, 64);
  {
    const Outcome outcome = place.c3rt(command);
    CAPTURE(outcome.output);
    CHECK(outcome.status == 0);
    CHECK_THAT(outcome.output,
               Contains("of object/estimate, robot/state on domain") && Contains("40 samples"));
    wire::ObjectEstimate estimate{};
    REQUIRE(estimates.take(estimate));
    CHECK(estimate.header.time_ns - estimate.exposure_ns == 500'000);
    CHECK(estimate.header.session_id != 7);
  }
  wire::Writer<wire::ObjectEstimate> writer(bus);
  const std::string pid = "(pid " + std::to_string(getpid());
  const Outcome named = place.c3rt(command + " --topics object/estimate");
  CHECK(named.status == 2);
  CHECK_THAT(named.output, Contains(pid) && Contains("writes object/estimate on domain"));
  const Outcome rest = place.c3rt(command);
  CHECK(rest.status == 0);
  CHECK_THAT(rest.output,
             Contains("object/estimate is left out: ") && Contains(pid) && Contains("20 samples"));
}
