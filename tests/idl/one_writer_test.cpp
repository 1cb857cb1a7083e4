#include "idl/one_writer.hpp"

#include <limits>

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::wire;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSilence = 100 * kMs;
constexpr std::int32_t kAnyStrength = std::numeric_limits<std::int32_t>::min();

TEST_CASE("OneWriter: the first of equals leads, another is refused while it speaks") {
  OneWriter rule(kSilence, kAnyStrength);
  CHECK(rule.leader() == 0);
  for (int i = 0; i < 1000; ++i) {
    CHECK(rule.admits(1, 0, i * kMs));
    CHECK_FALSE(rule.admits(2, 0, i * kMs + kMs / 2));
  }
  CHECK(rule.leader() == 1);
}

TEST_CASE("OneWriter: the stronger one leads at once, and the weaker never again beside it") {
  OneWriter rule(kSilence, kAnyStrength);
  CHECK(rule.admits(1, 0, 0));
  CHECK(rule.admits(2, kProcessStrength, kMs));
  CHECK_FALSE(rule.admits(1, 0, 2 * kMs));
}

TEST_CASE(
    "OneWriter: who speaks on after the leader fell silent takes over, in twice the silence") {
  OneWriter rule(kSilence, kAnyStrength);
  CHECK(rule.admits(1, kProcessStrength, 0));
  std::int64_t took_over_ns = 0;
  for (std::int64_t now_ns = kMs; took_over_ns == 0 && now_ns < 1000 * kMs; now_ns += kMs) {
    if (rule.admits(2, kProcessStrength, now_ns)) took_over_ns = now_ns;
  }
  CHECK(took_over_ns > kSilence);
  CHECK(took_over_ns <= 2 * kSilence);
  CHECK_FALSE(rule.admits(1, kProcessStrength, took_over_ns + kMs));
}

TEST_CASE("OneWriter: a weaker one takes nothing over from a process that is only stalled") {
  OneWriter rule(kSilence, kAnyStrength);
  CHECK(rule.admits(1, kProcessStrength, 0));
  CHECK_FALSE(rule.leader_is_silent(kSilence));
  for (std::int64_t now_ns = kMs; now_ns < 2000 * kMs; now_ns += kMs)
    CHECK_FALSE(rule.admits(2, 0, now_ns));
  CHECK(rule.leader_is_silent(2000 * kMs));
  rule.retire();  // it has gone
  CHECK(rule.admits(2, 0, 2001 * kMs));
  CHECK(rule.admits(1, kProcessStrength, 2002 * kMs));  // and comes back
}

TEST_CASE("OneWriter: one stray sample takes nothing over, however long the leader was silent") {
  OneWriter rule(kSilence, kAnyStrength);
  CHECK(rule.admits(1, 0, 0));
  CHECK_FALSE(rule.admits(2, 0, 5000 * kMs));
  CHECK(rule.admits(1, 0, 5001 * kMs));
}

TEST_CASE("OneWriter: a reader that stood still itself keeps its leader") {
  OneWriter rule(kSilence, kAnyStrength);
  CHECK(rule.admits(1, 0, 0));
  // what had piled up comes at once, the stranger's first
  for (int i = 0; i < 64; ++i) CHECK_FALSE(rule.admits(2, 0, 1000 * kMs + i));
  CHECK(rule.admits(1, 0, 1000 * kMs + 100));
  CHECK_FALSE(rule.admits(2, 0, 1001 * kMs));
}

TEST_CASE("OneWriter: in lockstep silence is nothing and a weaker writer nobody") {
  OneWriter rule(0, kProcessStrength);
  CHECK_FALSE(rule.admits(2, 0, 0));
  CHECK(rule.leader() == 0);
  CHECK(rule.admits(1, kProcessStrength, 0));
  CHECK_FALSE(rule.admits(3, kProcessStrength, 1'000'000 * kMs));
  CHECK_FALSE(rule.admits(3, kProcessStrength, 2'000'000 * kMs));
}

}  // namespace
