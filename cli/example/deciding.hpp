#pragma once
#include <optional>

namespace c3rt::cli {

/// Who decides in an example, and what is kept of it.
struct Deciding {
  std::optional<double> exact_limit = {};  // the exact search, of at most this long [s]; else C3
  bool trace = false;                      // of C3: its iterates
};

}  // namespace c3rt::cli
