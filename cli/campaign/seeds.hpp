#pragma once
// Which seeds a campaign runs.
#include <cstdint>
#include <string>
#include <vector>

namespace c3rt::cli::campaign {

/// "1..50", "1,5,9..12": the seeds in the order written.
/// @throws UsageError that says what was expected, also for a seed named twice and for more than
/// 100000 of them
std::vector<std::uint64_t> parse_seeds(const std::string& text);

}  // namespace c3rt::cli::campaign
