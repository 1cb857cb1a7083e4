#include "cli/lock.hpp"

#include <csignal>
#include <optional>

#include <catch2/catch.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/paths.hpp"
#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt::cli;

Instance someone() {
  Instance instance;
  instance.pid = getpid();
  instance.verb = "up";
  instance.scenario = "circle_slow";
  instance.started = "12:00:00";
  return instance;
}

}  // namespace

TEST_CASE(
    "a second instance on a busy domain is refused with who holds it, and another domain is free") {
  const Folder temporary;
  const auto& folder = temporary.path();
  {
    const DomainLock lock(folder, 3, someone());
    REQUIRE_THROWS_AS(DomainLock(folder, 3, someone()), UsageError);
    REQUIRE_THROWS_WITH(DomainLock(folder, 3, someone()),
                        Catch::Contains("domain 3 is busy") &&
                            Catch::Contains("c3rt up circle_slow") &&
                            Catch::Contains(std::to_string(getpid())));
    REQUIRE_NOTHROW(DomainLock(folder, 4, someone()));
    REQUIRE(holder(folder, 3)->scenario == "circle_slow");
  }
  REQUIRE_FALSE(holder(folder, 3).has_value());
  REQUIRE_NOTHROW(DomainLock(folder, 3, someone()));
}

TEST_CASE("the lock of a killed instance is free again, and its last word stays") {
  const Folder temporary;
  const auto& folder = temporary.path();
  int ready[2];
  REQUIRE(pipe(ready) == 0);
  const pid_t pid = fork();
  if (pid == 0) {
    DomainLock lock(folder, 1, someone());
    lock.set_ended("planner crashed");
    if (write(ready[1], "x", 1) != 1) _exit(1);
    pause();
    _exit(0);
  }
  char byte = 0;
  REQUIRE(read(ready[0], &byte, 1) == 1);
  REQUIRE(holder(folder, 1).has_value());
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
  REQUIRE_FALSE(holder(folder, 1).has_value());
  REQUIRE(last_instance(folder, 1)->ended == "planner crashed");
}
