#pragma once
// `c3rt scenario`: what a run depends on, as a person may read it.
#include <string>
#include <vector>

namespace c3rt::cli {

/// Prints the scenario whole, with what it extends and the overrides: YAML that can be run, with
/// the file and line of every value as a comment. @throws UsageError, config::ConfigError if it
/// cannot be run
int print_scenario(const std::string& scenario, const std::vector<std::string>& overrides);

/// Prints one object of JSON: the scenario's `file`; `is_example`, whether it is a numerical
/// example; `own_text`, the scenario with what it extends, and `text`, the same with the overrides,
/// each as YAML that needs no other file; `values`, the same as objects and lists, every single
/// value as text; `files` that values name, with their paths. @throws as print_scenario
int print_scenario_json(const std::string& scenario, const std::vector<std::string>& overrides);

/// Prints the name and the description of every scenario that is shipped.
int list_scenarios();

/// Prints every key that the readers of these scenarios ask for, as a table in Markdown: what is
/// expected, and what stands in the place of a key that is left out. Without one: of all that are
/// shipped, which is docs/scenario_keys.md.
int print_keys(const std::string& scenario, const std::vector<std::string>& overrides);

}  // namespace c3rt::cli
