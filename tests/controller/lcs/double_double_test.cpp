#include "controller/lcs/double_double.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "tests/support/random.hpp"

using namespace c3rt;
using lcs::DoubleDouble;

namespace {

DoubleDouble random_number(support::Random& random) {
  const double high = random.uniform() * std::ldexp(1.0, random.index(40) - 20);
  return lcs::fast_two_sum(high, 1e-17 * high * random.uniform());
}

double relative(DoubleDouble difference, double size) {
  return std::abs(difference.high + difference.low) / size;
}

}  // namespace

TEST_CASE("double-double: sums and products of doubles are exact") {
  support::Random random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const double a = random.uniform(), b = random.uniform() * std::ldexp(1.0, -random.index(60));
    const DoubleDouble sum = lcs::two_sum(a, b), product = lcs::two_product(a, b);
    CHECK(sum.high == a + b);
    CHECK(product.high == a * b);
    CHECK(product.low == std::fma(a, b, -product.high));
    // a and b are multiples of 2⁻³² and 2⁻³² 2⁻⁶⁰: what is left of the sum has at most 64 digits
    CHECK(static_cast<long double>(sum.high) + sum.low == static_cast<long double>(a) + b);
  }
}

TEST_CASE("double-double: the field's rules hold to 31 digits") {
  support::Random random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const DoubleDouble a = random_number(random), b = random_number(random),
                       c = random_number(random);
    CHECK(relative((a + b) - b - a, std::abs(a.high) + std::abs(b.high)) < 1e-30);
    CHECK(relative((a + b) * c - (a * c + b * c),
                   std::abs(c.high) * (std::abs(a.high) + std::abs(b.high))) < 1e-30);
    CHECK(relative(a / b * b - a, std::abs(a.high)) < 1e-30);
    CHECK(relative(a * b - b * a, std::abs(a.high * b.high)) < 1e-31);
  }
}

TEST_CASE("double-double: a third, three times, is 1 to 32 digits, and not in double") {
  const DoubleDouble third = DoubleDouble{1.0} / DoubleDouble{3.0};
  CHECK(third.low != 0.0);
  CHECK(relative(third + third + third - DoubleDouble{1.0}, 1.0) < 1e-31);
}
