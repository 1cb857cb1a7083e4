#include "cli/program.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string_view>
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

/// As exec takes them.
std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (const std::string& text : texts) all.push_back(const_cast<char*>(text.c_str()));
  all.push_back(nullptr);
  return all;
}

/// This process's environment with these in place of what it has of their names.
std::vector<std::string> with(const std::vector<std::string>& changed) {
  std::vector<std::string> all = changed;
  for (char** own = environ; *own != nullptr; ++own) {
    const std::string_view entry = *own;
    const auto same_name = [&](const std::string& other) {
      return other.compare(0, other.find('=') + 1, entry.substr(0, entry.find('=') + 1)) == 0;
    };
    if (std::none_of(changed.begin(), changed.end(), same_name)) all.emplace_back(entry);
  }
  return all;
}

}  // namespace

ProgramEnd run_program(const std::vector<std::string>& arguments, const std::string& input,
                       double timeout_s, const std::vector<std::string>& environment) {
  const MemoryFile in("input"), out("output");
  in.fill(input);
  const std::vector<char*> words = pointers(arguments);
  const std::vector<std::string> settings = with(environment);
  ProgramEnd end;
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, words[0], Streams(in.descriptor(), out.descriptor()).get(),
                                 Attributes().get(), words.data(), pointers(settings).data());
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
  const std::vector<char*> words = pointers(arguments);
  execvp(words[0], words.data());
  throw UsageError(arguments.front() + ": " + std::strerror(errno));
}

}  // namespace c3rt::cli
