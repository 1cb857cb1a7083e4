#pragma once
#include <cstdio>
#include <string>

namespace c3rt::base {

/// As printf, at most 255 letters.
template <typename... Values>
std::string words(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

}  // namespace c3rt::base
