#pragma once

#include <cmath>

namespace c3rt::lcs {

/// A number of some 32 digits: the unevaluated sum of two doubles, |low| ≤ ulp(high)/2 [Dekker
/// 1971]. Needs every operation rounded on its own, to double: no contraction, no -ffast-math. A
/// product beyond 1e300 is not finite. RT: no heap, no lock, no throw.
struct DoubleDouble {
  double high = 0.0, low = 0.0;
};

/// a + b where |a| ≥ |b|, exactly.
inline DoubleDouble fast_two_sum(double a, double b) noexcept {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

/// a + b, exactly.
inline DoubleDouble two_sum(double a, double b) noexcept {
  const double sum = a + b, b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

/// a b, exactly.
inline DoubleDouble two_product(double a, double b) noexcept {
  constexpr double kSplit = 134217729.0;  // 2²⁷ + 1
  const double product = a * b;
  const double a_scaled = kSplit * a, b_scaled = kSplit * b;
  const double a_high = a_scaled - (a_scaled - a), a_low = a - a_high;
  const double b_high = b_scaled - (b_scaled - b), b_low = b - b_high;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

inline DoubleDouble operator-(DoubleDouble a) noexcept { return {-a.high, -a.low}; }

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) noexcept {
  DoubleDouble sum = two_sum(a.high, b.high);
  const DoubleDouble rest = two_sum(a.low, b.low);
  sum = fast_two_sum(sum.high, sum.low + rest.high);
  return fast_two_sum(sum.high, sum.low + rest.low);
}

inline DoubleDouble operator-(DoubleDouble a, DoubleDouble b) noexcept { return a + -b; }

inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) noexcept {
  const DoubleDouble product = two_product(a.high, b.high);
  return fast_two_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

inline DoubleDouble operator/(DoubleDouble a, DoubleDouble b) noexcept {
  // long division: three digits of 53 bits each
  const double first = a.high / b.high;
  DoubleDouble rest = a - b * DoubleDouble{first};
  const double second = rest.high / b.high;
  rest = rest - b * DoubleDouble{second};
  const DoubleDouble sum = fast_two_sum(first, second);
  return sum + DoubleDouble{rest.high / b.high};
}

}  // namespace c3rt::lcs
