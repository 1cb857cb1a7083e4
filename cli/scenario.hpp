#pragma once
// `c3rt scenario`: what a run depends on, as a person may read it.
#include <string>
#include <vector>

namespace c3rt::cli {

/// Prints the scenario whole, with what it extends and the overrides: YAML that can be run, with
/// the file and line of every value as a comment. @throws UsageError, config::ConfigError if it
/// cannot be run
int print_scenario(const std::string& scenario, const std::vector<std::string>& overrides);

/// Prints the name and the description of every scenario that is shipped.
int list_scenarios();

}  // namespace c3rt::cli
