#pragma once
#include <stdexcept>

namespace c3rt::mjcf {

/// The message names the file, what it has that cannot be used, and what was expected.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace c3rt::mjcf
