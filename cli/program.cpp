#include "cli/program.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/paths.hpp"
#include "cli/supervisor.hpp"
#include "controller/base/words.hpp"

namespace c3rt::cli {
namespace {

using std::chrono::steady_clock;

constexpr std::size_t kMostOutput = 1 << 20;  // bytes

/// A file in memory: no pipe that could be full, or broken by a reader that has gone.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : descriptor_(memfd_create(name, MFD_CLOEXEC)) {
    if (descriptor_ < 0)
      throw std::runtime_error(std::string("cannot make a file in memory: ") +
                               std::strerror(errno));
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  int descriptor() const { return descriptor_; }

  void fill(const std::string& text) const {
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t count = write(descriptor_, text.data() + done, text.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0)
        throw std::runtime_error(std::string("cannot write a file in memory: ") +
                                 std::strerror(errno));
      done += static_cast<std::size_t>(count);
    }
    lseek(descriptor_, 0, SEEK_SET);
  }
  std::string text() const {
    std::string all;
    char part[4096];
    for (ssize_t count = 0; all.size() < kMostOutput; all.append(part, count)) {
      count = pread(descriptor_, part, sizeof part, static_cast<off_t>(all.size()));
      if (count <= 0) break;
    }
    return all;
  }

 private:
  int descriptor_;
};

/// The child's own signals and group: the terminal's Ctrl-C reaches us alone.
class Attributes {
 public:
  Attributes() {
    posix_spawnattr_init(&attributes_);
    sigset_t none, ordinary;
    sigemptyset(&none);
    sigemptyset(&ordinary);
    for (const int number : {SIGPIPE, SIGINT, SIGTERM}) sigaddset(&ordinary, number);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &ordinary);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~Attributes() { posix_spawnattr_destroy(&attributes_); }
  Attributes(const Attributes&) = delete;
  Attributes& operator=(const Attributes&) = delete;
  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

class Streams {
 public:
  Streams(int input, int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, input, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
  }
  ~Streams() { posix_spawn_file_actions_destroy(&actions_); }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

}  // namespace

ProgramEnd run_program(const std::vector<std::string>& arguments, const std::string& input,
                       double timeout_s) {
  const MemoryFile in("input"), out("output");
  in.fill(input);
  std::vector<char*> words;
  for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  ProgramEnd end;
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, words[0], Streams(in.descriptor(), out.descriptor()).get(),
                                 Attributes().get(), words.data(), environ);
  if (error != 0) {
    end.reason = error == ENOENT ? "is not installed"
                                 : std::string("cannot be started: ") + std::strerror(error);
    return end;
  }
  const auto deadline = steady_clock::now() + std::chrono::duration<double>(timeout_s);
  int status = 0;
  bool ended = false;
  while (!(ended = waitpid(pid, &status, WNOHANG) == pid) && steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(-pid, SIGKILL);  // what it started itself must not outlive it
  if (!ended) waitpid(pid, &status, 0);
  end.output = out.text();
  if (!ended) {
    end.kind = ProgramEnd::Kind::kTimedOut;
    end.reason = base::words("did not end within %g s", timeout_s);
  } else if (WIFEXITED(status)) {
    end.kind = ProgramEnd::Kind::kExited;
    end.status = WEXITSTATUS(status);
    end.reason = describe_exit(status);
  } else {
    end.kind = ProgramEnd::Kind::kSignalled;
    end.reason = describe_exit(status);
  }
  return end;
}

void become_program(const std::vector<std::string>& arguments) {
  std::vector<char*> words;
  for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  execvp(words[0], words.data());
  throw UsageError(arguments.front() + ": " + std::strerror(errno));
}

}  // namespace c3rt::cli
