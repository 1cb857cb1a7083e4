#include "cli/restart_policy.hpp"

#include <catch2/catch.hpp>

using c3rt::cli::RestartPolicy;

TEST_CASE("restart policy: at once, then after waits that double") {
  RestartPolicy policy;
  CHECK(policy.died(100.0).value() == 100.0);
  CHECK(policy.died(101.0).value() - 101.0 == Approx(0.2));
  CHECK(policy.died(102.0).value() - 102.0 == Approx(0.4));
  CHECK(policy.died(103.0).value() - 103.0 == Approx(0.8));
  CHECK(policy.died(104.0).value() - 104.0 == Approx(1.6));
}

TEST_CASE("restart policy: what dies more than five times in 30 s is given up") {
  RestartPolicy policy;
  for (int i = 0; i < RestartPolicy::kMost; ++i) CHECK(policy.died(i).has_value());
  CHECK_FALSE(policy.died(5.0).has_value());
  CHECK(policy.deaths() == 6);
}

TEST_CASE("restart policy: what dies now and then is started again at once, however often") {
  RestartPolicy policy;
  for (int i = 0; i < 1000; ++i) {
    const double now = 31.0 * i;
    CHECK(policy.died(now).value() == now);
  }
  CHECK(policy.deaths() == 1000);
}
