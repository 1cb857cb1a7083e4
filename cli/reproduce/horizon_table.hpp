#pragma once
// What Tables I and II share: solve time and accumulated cost over the horizon N.
#include <array>
#include <string>
#include <vector>

#include "cli/reproduce/context.hpp"

namespace c3rt::cli::reproduce {

constexpr std::array<int, 4> kHorizons{10, 20, 30, 50};

/// Numbers of others, as they print them, one for each horizon.
struct Reference {
  std::string name;
  std::array<const char*, kHorizons.size()> values;
};

struct HorizonTable {
  std::string title, scenario;
  Overrides published;  // what the paper runs, on top of the scenario
  Overrides own;        // settings of our own, on top of these
  std::string own_words;
  bool has_limits;               // of the states, which a simulation may overshoot
  double cost_unit;              // of the table: 1e7
  std::vector<Reference> times;  // [ms]
  std::vector<Reference> costs;  // [cost_unit]
};

void run_horizon_table(const Context& context, const HorizonTable& table);

}  // namespace c3rt::cli::reproduce
