#pragma once
// Starts processes, watches them and leaves none behind.
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

namespace c3rt::cli {

struct ChildSpec {
  std::string name;                    // "planner"
  std::vector<std::string> arguments;  // of exec, the program's path first
  std::filesystem::path log;           // its standard output and error; empty: ours
  bool again = false;                  // started anew: behind what the log has
};

/// How a child ended that nobody had asked to end.
struct ChildExit {
  std::string name;
  std::string reason;  // "exited with status 2", "was killed by signal 11 (Segmentation fault)"
  std::filesystem::path log;
  int status = 0;  // of waitpid
};

/// The children of one run. Each is the leader of its own process group, so that Ctrl-C on the
/// terminal reaches only the supervisor, which then ends them in order; and each dies with the
/// thread that started it, however that one ends. One thread calls everything.
class Supervisor {
 public:
  Supervisor() = default;
  ~Supervisor();  // stop()
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// @throws std::runtime_error naming the child whose program or log cannot be opened
  void start(const ChildSpec& spec);

  /// The first child that has ended by itself; nothing while all run. Reaps what ended.
  std::optional<ChildExit> poll();

  /// The same, and forgets the child: for children that are meant to end by themselves.
  std::optional<ChildExit> take_ended();

  /// SIGTERM to every child's group, then SIGKILL to those that are left after the grace.
  /// @return the names of those that had to be killed
  std::vector<std::string> stop(double grace_s = 5.0);

  /// The children that are running, with their process ids.
  std::vector<std::pair<std::string, pid_t>> pids() const;
  /// How many children are running.
  int running() const;

 private:
  struct Child {
    ChildSpec spec;
    pid_t pid;
    bool ended;
    int status;  // of waitpid
  };
  bool reap(Child& child);
  static ChildExit exit_of(const Child& child);
  std::vector<Child> children_;
};

/// The name of a child's end, from waitpid's status.
std::string describe_exit(int status);

}  // namespace c3rt::cli
