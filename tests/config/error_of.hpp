#pragma once

#include <functional>
#include <string>

#include "config/config_error.hpp"

namespace c3rt::test {

/// What a ConfigError of this action says, or "no error".
inline std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const config::ConfigError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace c3rt::test
