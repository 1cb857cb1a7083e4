#pragma once
// What each command can look like: the end of its --help.
#include <string>
#include <vector>

namespace c3rt::cli {

struct Example {
  std::string line;  // as it is typed
  std::string what;  // may be empty
};

/// Of one command: "run", "fault push-object"; "" is c3rt itself.
/// @throws std::out_of_range for a command that has none: every command has at least two
const std::vector<Example>& examples_of(const std::string& command);

/// The same as the footer of a help text.
std::string examples_text(const std::string& command);

}  // namespace c3rt::cli
