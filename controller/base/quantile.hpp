#pragma once
// Quantiles of samples.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace c3rt::base {

/// Nearest rank: the how-many-th of so many sorted samples is the smallest one that at least the
/// given share does not exceed, counted from 1. RT: no heap, no lock, no throw.
inline std::uint64_t nearest_rank(std::uint64_t count, double share) noexcept {
  const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count)));
  return std::max<std::uint64_t>(rank, 1);
}

/// Quantile by nearest rank: always one of the samples, as a latency is reported.
/// @param sorted at least one
inline double quantile_nearest(const std::vector<double>& sorted, double share) {
  return sorted[nearest_rank(sorted.size(), share) - 1];
}

/// Quantile linear between the two samples around it (R's type 7), as a campaign's tables have it.
/// @param sorted at least one
inline double quantile_linear(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace c3rt::base
