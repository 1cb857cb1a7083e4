#pragma once
// What many runs of one scenario amount to.
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace c3rt::cli::campaign {

using nlohmann::ordered_json;

/// A share and the interval that holds the true one with 95 % confidence.
struct Proportion {
  int successes, count;
  double share, low, high;
};

/// Wilson's score interval, which also says something of 20 successes in 20.
/// @param count at least 1
Proportion wilson(int successes, int count);

/// One figure over the runs that give it.
struct Distribution {
  int count;
  double mean, p05, median, p95, worst;
  std::size_t worst_index;  // into the values
};

/// @param values at least one, all finite
Distribution distribution(const std::vector<double>& values, bool higher_is_better);

/// Every number of a report by its path ("objects.0.rms_error_m"): of a list of numbers its median
/// and worst, of the reflexes how many. The criteria are not among them.
std::vector<std::pair<std::string, double>> figures(const ordered_json& report);

/// Whether more of a figure of a report is better.
bool higher_is_better(const std::string& figure);

}  // namespace c3rt::cli::campaign
