#include "controller/base/random.hpp"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using c3rt::base::Random;

TEST_CASE("random: the same seed gives the same bits, another seed others") {
  Random a(3), b(3), c(4);
  bool different = false;
  for (int k = 0; k < 100; ++k) {
    const double x = k % 3 == 0 ? a.normal() : a.uniform();
    REQUIRE(x == (k % 3 == 0 ? b.normal() : b.uniform()));
    different = different || x != c.uniform();
  }
  CHECK(different);
}

TEST_CASE("random: uniform numbers are those of the standard's engine, scaled") {
  // the standard fixes the 10000th number of mt19937_64 with its own seed
  std::mt19937_64 engine;
  engine.discard(9999);
  REQUIRE(engine() == 9981545732273789042ULL);
  Random random(std::mt19937_64::default_seed);
  for (int k = 0; k < 9999; ++k) random.uniform();
  CHECK(random.uniform() == std::floor(9981545732273789042.0L / 2048.0L) / 9007199254740992.0L);
}

TEST_CASE("random: normal numbers have the normal's moments and shares") {
  Random random(11);
  constexpr int kSamples = 200000;
  double sum = 0.0, squares = 0.0, fourth = 0.0;
  int within_one = 0, within_two = 0;
  for (int k = 0; k < kSamples; ++k) {
    const double x = random.normal();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
    within_one += std::abs(x) < 1.0;
    within_two += std::abs(x) < 2.0;
  }
  const double n = kSamples;
  // five standard errors each: 1, sqrt(2), sqrt(96) and those of a share
  CHECK(std::abs(sum / n) < 5.0 / std::sqrt(n));
  CHECK(std::abs(squares / n - 1.0) < 5.0 * std::sqrt(2.0 / n));
  CHECK(std::abs(fourth / n - 3.0) < 5.0 * std::sqrt(96.0 / n));
  CHECK(std::abs(within_one / n - 0.682689) < 5.0 * std::sqrt(0.6827 * 0.3173 / n));
  CHECK(std::abs(within_two / n - 0.954500) < 5.0 * std::sqrt(0.9545 * 0.0455 / n));
}
