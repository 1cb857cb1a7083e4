#include "tests/support/own_domain.hpp"

#include <catch2/catch.hpp>
#include <sys/wait.h>

using c3rt::support::kOwnDomain;
using c3rt::support::take_domain;

TEST_CASE("own domain: nobody else gets it while it is held, in this process or another") {
  CHECK(kOwnDomain >= 1);
  CHECK(kOwnDomain <= 76);
  const std::uint32_t second = take_domain();
  CHECK(second != kOwnDomain);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const std::uint32_t third = take_domain();
    _exit(third == kOwnDomain || third == second ? 1 : 0);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
}
