#include "cli/supervisor.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace c3rt::cli {
namespace {

using std::chrono::steady_clock;

/// Only what is allowed between fork and exec in a process with threads.
[[noreturn]] void become(char* const* arguments, int log, int errors, pid_t parent) {
  const auto give_up = [&] {
    const int reason = errno;
    if (write(errors, &reason, sizeof reason) < 0) _exit(126);
    _exit(127);
  };
  // dies with the supervisor; the second look closes the gap before prctl
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) give_up();
  if (getppid() != parent) _exit(127);
  setpgid(0, 0);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  signal(SIGPIPE, SIG_DFL);
  const int nothing = open("/dev/null", O_RDONLY);
  if (nothing < 0 || dup2(nothing, 0) < 0) give_up();
  if (log >= 0 && (dup2(log, 1) < 0 || dup2(log, 2) < 0)) give_up();
  execv(arguments[0], arguments);
  give_up();
  _exit(127);
}

/// @return a descriptor, -1 where there is to be none
int open_log(const ChildSpec& spec) {
  if (spec.log.empty()) return -1;
  std::error_code error;
  std::filesystem::create_directories(spec.log.parent_path(), error);
  const int log =
      open(spec.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | (spec.again ? 0 : O_TRUNC),
           0644);
  if (log < 0)
    throw std::runtime_error(spec.name + ": cannot write " + spec.log.string() + ": " +
                             std::strerror(errno));
  return log;
}

}  // namespace

Supervisor::~Supervisor() { stop(); }

void Supervisor::start(const ChildSpec& spec) {
  const int log = open_log(spec);
  int errors[2];
  if (pipe2(errors, O_CLOEXEC) != 0) {
    if (log >= 0) close(log);
    throw std::runtime_error(spec.name + ": " + std::strerror(errno));
  }
  std::vector<char*> arguments;
  for (const std::string& argument : spec.arguments)
    arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);

  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) become(arguments.data(), log, errors[1], parent);
  const int fork_error = errno;
  if (log >= 0) close(log);
  close(errors[1]);
  // the pipe closes by itself when exec succeeds
  int reason = pid < 0 ? fork_error : 0;
  if (pid > 0 && read(errors[0], &reason, sizeof reason) != sizeof reason) reason = 0;
  close(errors[0]);
  if (reason != 0) {
    if (pid > 0) waitpid(pid, nullptr, 0);
    throw std::runtime_error(spec.name + ": cannot start " + spec.arguments.front() + ": " +
                             std::strerror(reason));
  }
  setpgid(pid, pid);  // also here: a signal to the group must find it from now on
  children_.push_back({spec, pid, false, 0});
}

bool Supervisor::reap(Child& child) {
  if (child.ended) return true;
  child.ended = waitpid(child.pid, &child.status, WNOHANG) == child.pid;
  return child.ended;
}

std::optional<ChildExit> Supervisor::poll() {
  for (Child& child : children_) {
    if (reap(child)) return exit_of(child);
  }
  return std::nullopt;
}

std::optional<ChildExit> Supervisor::take_ended() {
  const auto ended = std::find_if(children_.begin(), children_.end(),
                                  [this](Child& child) { return reap(child); });
  if (ended == children_.end()) return std::nullopt;
  const ChildExit result = exit_of(*ended);
  kill(-ended->pid, SIGKILL);  // what it started itself must not outlive it
  children_.erase(ended);
  return result;
}

ChildExit Supervisor::exit_of(const Child& child) {
  return {child.spec.name, describe_exit(child.status), child.spec.log, child.status};
}

std::vector<std::string> Supervisor::stop(double grace_s) {
  const auto all_ended = [&] {
    bool all = true;
    for (Child& child : children_) all = reap(child) && all;
    return all;
  };
  if (!all_ended()) {
    for (const Child& child : children_) {
      if (!child.ended) kill(-child.pid, SIGTERM);
    }
  }
  const auto deadline = steady_clock::now() + std::chrono::duration<double>(grace_s);
  while (!all_ended() && steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::vector<std::string> killed;
  for (Child& child : children_) {
    if (!child.ended) killed.push_back(child.spec.name);
    // the group as well: what a child started itself must not outlive it
    kill(-child.pid, SIGKILL);
    if (!child.ended) waitpid(child.pid, &child.status, 0);
  }
  children_.clear();
  return killed;
}

std::vector<std::pair<std::string, pid_t>> Supervisor::pids() const {
  std::vector<std::pair<std::string, pid_t>> result;
  for (const Child& child : children_) {
    if (!child.ended) result.emplace_back(child.spec.name, child.pid);
  }
  return result;
}

int Supervisor::running() const {
  int count = 0;
  for (const Child& child : children_) count += child.ended ? 0 : 1;
  return count;
}

std::string describe_exit(int status) {
  if (WIFSIGNALED(status)) {
    const int signal_number = WTERMSIG(status);
    return "was killed by signal " + std::to_string(signal_number) + " (" +
           strsignal(signal_number) + ")";
  }
  return "exited with status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace c3rt::cli
