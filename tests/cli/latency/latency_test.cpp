// The command as a person meets it, with small shells in the place of the four processes.
#include <filesystem>
#include <string>

#include <catch2/catch.hpp>

#include "tests/cli/place.hpp"

using namespace c3rt::cli;
using c3rt::support::Outcome;
using Catch::Contains;

TEST_CASE(
    "latency: a profile that is not there, an example and a time too short are refused in plain "
    "words") {
  const Place place(93);
  for (const auto& [arguments, said] : std::vector<std::pair<std::string, std::string>>{
           {"--profile no_such_profile", "unknown DDS profile \"no_such_profile\"; known: "},
           {"cart_pole", "cart_pole is a numerical example"},
           {"no_such_scenario", "unknown scenario \"no_such_scenario\""},
           {"--duration 1", "--duration: expected a number from 6 to 3600"},
           {"--load -1", "--load: expected a whole number from 0"}}) {
    const Outcome outcome =
        place.c3rt("latency " + arguments + " --out '" + place.out().string() + "'");
    CAPTURE(arguments);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains(said));
  }
}

TEST_CASE(
    "latency: a process that dies ends the measurement with its name, and leaves nothing behind") {
  const Place place(93);
  place.process("planner", "echo out of plans; exit 7");
  const Outcome outcome = place.c3rt("latency circle_slow --duration 6" + place.start_options());
  CHECK(outcome.status == 3);
  CHECK_THAT(outcome.output, Contains("planner exited with status 7") && Contains("out of plans"));
  CHECK(place.empty());
}

TEST_CASE("latency: Ctrl-C ends it at once, with status 1, no report and nothing left behind") {
  const Place place(93);
  const Outcome outcome = c3rt::support::outcome_of(
      place.command("latency circle_slow --duration 60" + place.start_options()) +
      " & until [ -d '" + (place.out() / "logs").string() +
      "' ]; do sleep 0.05; done; kill -INT $!; wait $!");
  CHECK(outcome.status == 1);
  CHECK_THAT(outcome.output, Contains("interrupted, there is no report"));
  CHECK_FALSE(std::filesystem::exists(place.out() / "latency.json"));
  CHECK(place.empty());
}
