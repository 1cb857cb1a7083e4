#pragma once
// What the processes of one's own check, and how numbers of a client come into samples.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <stdexcept>

#include "controller/base/words.hpp"

namespace c3rt::client {

/// @throws std::invalid_argument "rate: expected 1 to 1000, got 0.5"
inline void require_within(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument(base::words("%s: expected %g to %g, got %g", name, low, high, value));
}

template <std::size_t n>
void fill(double (&out)[n], const std::array<double, n>& values) {
  std::copy(values.begin(), values.end(), out);
}

/// A quaternion, scaled to norm 1; zeros stay, and no reader lets them in.
inline void fill_unit(double (&out)[4], const std::array<double, 4>& q) {
  const double norm = std::sqrt(std::inner_product(q.begin(), q.end(), q.begin(), 0.0));
  fill(out, q);
  for (double& value : out) value /= norm > 0.0 ? norm : 1.0;
}

}  // namespace c3rt::client
