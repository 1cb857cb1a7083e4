#pragma once
// What a command says and how it ends.
#include <cstdio>
#include <stdexcept>
#include <string>

#include <sys/wait.h>

namespace c3rt::support {

struct Outcome {
  int status;          // exit status; -1 if a signal ended it
  std::string output;  // standard output and error
};

/// Runs it in a shell and waits for its end.
inline Outcome outcome_of(const std::string& command) {
  FILE* pipe = popen(("exec 2>&1; " + command).c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  Outcome outcome{};
  char buffer[4096];
  while (const std::size_t count = std::fread(buffer, 1, sizeof buffer, pipe))
    outcome.output.append(buffer, count);
  const int status = pclose(pipe);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

}  // namespace c3rt::support
