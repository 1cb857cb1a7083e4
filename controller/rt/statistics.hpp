#pragma once
// Quantiles of durations, collected by a real-time thread and read by another.
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "controller/base/quantile.hpp"

namespace c3rt::rt {

/// What a Statistics holds at one moment [s].
struct Quantiles {
  std::uint64_t count = 0;
  double p50_s = 0.0;
  double p95_s = 0.0;
  double p99_s = 0.0;
  double p999_s = 0.0;
  double max_s = 0.0;  // exact
};

/// Logarithmic histogram of durations, 64 buckets per octave from 2⁻³⁰ s (1 ns) to 2¹⁰ s: a
/// quantile is within 0.8 % of the sample that it names. One thread adds, any thread reads.
class Statistics {
 public:
  /// One duration. What is shorter than 1 ns, negative or not a number counts as the shortest.
  /// RT: no heap, no lock, no throw.
  void add(double duration_s) noexcept {
    // one writer: a plain load and store is enough, and readers may be one sample behind
    auto& bucket = buckets_[static_cast<std::size_t>(index(duration_s))];
    bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (duration_s > max_s_.load(std::memory_order_relaxed)) {
      max_s_.store(duration_s, std::memory_order_relaxed);
    }
  }

  /// Quantiles by nearest rank.
  Quantiles snapshot() const noexcept {
    std::array<std::uint64_t, kBuckets> counts;
    Quantiles result;
    for (int i = 0; i < kBuckets; ++i) {
      counts[i] = buckets_[i].load(std::memory_order_relaxed);
      result.count += counts[i];
    }
    result.max_s = max_s_.load(std::memory_order_relaxed);
    if (result.count == 0) return result;
    const auto quantile = [&](double share) {
      const std::uint64_t rank = base::nearest_rank(result.count, share);
      std::uint64_t below = 0;
      for (int i = 0; i < kBuckets; ++i) {
        below += counts[i];
        if (below >= rank) return std::fmin(middle(i), result.max_s);
      }
      return result.max_s;
    };
    result.p50_s = quantile(0.5);
    result.p95_s = quantile(0.95);
    result.p99_s = quantile(0.99);
    result.p999_s = quantile(0.999);
    return result;
  }

 private:
  static constexpr int kPerOctave = 64;  // 2^6: the six highest bits of the mantissa
  static constexpr int kOctaves = 40;
  static constexpr int kBuckets = kPerOctave * kOctaves;
  static constexpr int kMantissaShift = 52 - 6;
  static constexpr std::int64_t kFirst =
      (1023 - 30) * std::int64_t{kPerOctave};  // 2⁻³⁰ s, biased exponent

  static int index(double duration_s) noexcept {
    if (!(duration_s > 0.0)) return 0;
    std::int64_t bits = 0;
    std::memcpy(&bits, &duration_s, sizeof bits);
    // exponent and high mantissa bits of an IEEE double are a piecewise linear logarithm
    const std::int64_t i = (bits >> kMantissaShift) - kFirst;
    return static_cast<int>(i < 0 ? 0 : (i >= kBuckets ? kBuckets - 1 : i));
  }
  static double middle(int i) noexcept {
    const double octave = std::ldexp(1.0, i / kPerOctave - 30);
    return octave * (1.0 + (i % kPerOctave + 0.5) / kPerOctave);
  }

  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
  std::atomic<double> max_s_{0.0};
};

}  // namespace c3rt::rt
