#pragma once
// Other people's programs: Python, coacd. Each may be missing, fail or hang, and none may take
// this one along.
#include <string>
#include <vector>

namespace c3rt::cli {

/// How a program ended.
struct ProgramEnd {
  enum class Kind { kExited, kNotFound, kTimedOut, kSignalled };
  Kind kind = Kind::kNotFound;
  int status = -1;     // of kExited
  std::string output;  // standard output and error together, the first MiB

  bool ok() const { return kind == Kind::kExited && status == 0; }
  /// "is not installed", "did not end within 20 s", "ended with status 1"
  std::string reason;
};

/// Runs arguments[0], looked up in PATH, with `input` as its standard input, and waits for its end.
/// After `timeout_s` it is killed with everything that it started.
/// @param environment "NAME=value", in place of what this process has of these names
ProgramEnd run_program(const std::vector<std::string>& arguments, const std::string& input,
                       double timeout_s, const std::vector<std::string>& environment = {});

/// Goes on as arguments[0], looked up in PATH, with this process's id and streams.
/// @throws UsageError saying why it cannot
[[noreturn]] void become_program(const std::vector<std::string>& arguments);

}  // namespace c3rt::cli
