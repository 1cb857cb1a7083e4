#include "cli/invariants/processes.hpp"

#include <catch2/catch.hpp>

using namespace c3rt::cli::invariants;

namespace {

constexpr std::uint64_t kMiB = 1 << 20;

ProcessSample sample(double memory_mib = 20.0) {
  ProcessSample result;
  result.name = "planner";
  result.pid = 41;
  result.memory = static_cast<std::uint64_t>(memory_mib * kMiB);
  result.threads = 8;
  result.descriptors = 20;
  result.log = 1000;
  return result;
}

struct World {
  Violations violations;
  Processes processes{{}, violations};
  /// Grows while it starts, then stays; until 5 minutes are over.
  World() {
    for (int t = 0; t <= 300; t += 5) processes.hear(t, sample(t < 100 ? 10.0 + 0.1 * t : 20.0));
  }
  std::uint64_t count(const char* name) const {
    const auto found = violations.counts().find(name);
    return found == violations.counts().end() ? 0 : found->second;
  }
};

}  // namespace

TEST_CASE("processes: one that stays as it was after 5 minutes violates nothing") {
  World world;
  for (int t = 305; t < 7200; t += 5) {
    ProcessSample small = sample(19.0 + 1.9 * (t % 2));  // within 1 MiB, and less
    small.threads = 8 - t % 2;
    small.log = 1000 + static_cast<std::uint64_t>(t);  // 1 byte a second
    world.processes.hear(t, small);
  }
  CHECK(world.violations.count() == 0);
  CHECK(world.processes.courses().at("planner").settled);
  CHECK(world.processes.courses().at("planner").at_settling.memory == 20 * kMiB);
}

TEST_CASE("processes: a leak is seen once it is more than 1 MiB above the value after 5 minutes") {
  World world;
  world.processes.hear(400, sample(21.0));
  CHECK(world.violations.count() == 0);
  world.processes.hear(405, sample(21.001));
  REQUIRE(world.count("memory") == 1);
  CHECK(world.violations.kept().front().subject == "planner");
  CHECK(world.violations.kept().front().limit == 21.0 * kMiB);
}

TEST_CASE("processes: a thread or a descriptor more than after 5 minutes is seen") {
  World world;
  ProcessSample more = sample();
  ++more.threads;
  world.processes.hear(400, more);
  CHECK(world.count("threads") == 1);
  more = sample();
  ++more.descriptors;
  world.processes.hear(405, more);
  CHECK(world.count("descriptors") == 1);
  CHECK(world.count("memory") == 0);
}

TEST_CASE("processes: a log that grows faster than 1 MiB an hour is seen, over every rotation") {
  World world;
  ProcessSample loud = sample();
  std::uint64_t written = 1000;
  for (int t = 305; t < 1200 && world.violations.count() == 0; t += 5) {
    written += 5000;               // 3.4 MiB an hour
    loud.log = written % 100'000;  // begun anew whenever it has 100 kB
    world.processes.hear(t, loud);
  }
  CHECK(world.count("log_growth") == 1);
}

TEST_CASE("processes: one that is gone is lost, another one in its place was restarted") {
  World world;
  ProcessSample gone;
  gone.name = "planner";
  world.processes.hear(400, gone);
  CHECK(world.count("lost") == 1);
  ProcessSample other = sample(30.0);
  other.pid = 42;
  world.processes.hear(410, other);
  CHECK(world.count("restarted") == 1);
  // it settles anew: more memory than the first one had is none of its faults
  world.processes.hear(420, other);
  CHECK(world.count("memory") == 0);
}

TEST_CASE("processes: one that was started again on purpose is no violation") {
  World world;
  world.processes.restarted("planner");
  ProcessSample other = sample(30.0);
  other.pid = 42;
  world.processes.hear(410, other);
  CHECK(world.violations.count() == 0);
}
