#pragma once
// Random numbers that a seed decides, the same with every standard library.
#include <cmath>
#include <cstdint>
#include <random>

namespace c3rt::base {

/// Numbers of mt19937_64, whose sequence the standard fixes. Its distributions it leaves open, so
/// these are our own.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [0, 1), a multiple of 2⁻⁵³.
  double uniform() noexcept { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  /// Standard normal, by Box and Muller's transform: two at a time.
  double normal() noexcept {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    constexpr double kTwoPi = 6.283185307179586476925;
    const double length = std::sqrt(-2.0 * std::log(uniform() + 0x1p-53));  // of (0, 1]
    const double angle = kTwoPi * (uniform() + 0x1p-53);
    spare_ = length * std::sin(angle);
    has_spare_ = true;
    return length * std::cos(angle);
  }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace c3rt::base
