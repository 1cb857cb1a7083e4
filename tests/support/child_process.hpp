#pragma once
// One of our programs as a child of a test; killed if the test forgets it.
#include <csignal>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace c3rt::test {

/// Path of one of the project's programs in this build.
inline std::string program(const std::string& name) {
  return std::string(C3RT_BINARY_DIRECTORY) + "/bin/" + name;
}

/// The command of one of the four processes on a domain of loopback.
inline std::vector<std::string> process_command(const std::string& name,
                                                const std::string& scenario, std::uint32_t domain,
                                                const std::vector<std::string>& more) {
  std::vector<std::string> command{
      program(name),          scenario,        "--domain",
      std::to_string(domain), "--dds-profile", C3RT_SOURCE_DIRECTORY "/config/dds/loopback.xml"};
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

class ChildProcess {
 public:
  /// @param output_path the file that gets stdout and stderr; empty: the test's own
  explicit ChildProcess(std::vector<std::string> arguments, const std::string& output_path = {}) {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (!output_path.empty()) {
      posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output_path.c_str(),
                                       O_WRONLY | O_CREAT | O_TRUNC, 0644);
      posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    }
    const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("cannot start " + arguments[0]);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  pid_t pid() const { return pid_; }
  void signal(int number) const { kill(pid_, number); }
  /// Exit status; -1 if a signal ended it.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
};

}  // namespace c3rt::test
