#pragma once
#include <stdexcept>
#include <string>

#include "config/text.hpp"

namespace c3rt::config {

/// "circle.yaml:12: planner.admm.iterations: expected an integer in [1, 50], got 0": one line, with
/// nothing in it that a terminal would obey.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(const std::string& text) : std::runtime_error(printable(text, 2000)) {}
};

}  // namespace c3rt::config
