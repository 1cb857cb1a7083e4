#include "cli/lock.hpp"

#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <thread>

#include <arpa/inet.h>
#include <catch2/catch.hpp>
#include <netinet/in.h>
#include <sys/socket.h>
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

TEST_CASE("a holder that is just ending is waited for") {
  const Folder temporary;
  auto ending = std::make_unique<DomainLock>(temporary.path(), 3, someone());
  std::thread end([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    ending.reset();
  });
  CHECK_NOTHROW(DomainLock(temporary.path(), 3, someone(), std::chrono::minutes(1)));
  end.join();
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

TEST_CASE("any domain is one that nobody holds and nobody listens on, another one each time") {
  const Folder temporary;
  const auto& folder = temporary.path();
  const auto first = lock_any_domain(folder, someone());
  const auto second = lock_any_domain(folder, someone());
  CHECK(first->domain() != second->domain());
  CHECK(holder(folder, first->domain()).has_value());

  // somebody whose locks are elsewhere listens where the first participant would
  const std::uint32_t heard = second->domain() - 1;
  const int other = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(7410 + 250 * heard));
  // taken already by a run on this machine: as good
  (void)bind(other, reinterpret_cast<sockaddr*>(&address), sizeof address);
  CHECK(lock_any_domain(folder, someone())->domain() < heard);
  close(other);
}
