// With small shells in the place of the four processes.
#include "cli/supervisor.hpp"

#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/paths.hpp"
#include "tests/cli/eventually.hpp"
#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt::cli;
namespace fs = std::filesystem;

ChildSpec shell(const Folder& folder, const std::string& name, const std::string& script) {
  return {name, {"/bin/bash", "-c", script}, folder.path() / "logs" / (name + ".log")};
}

pid_t pid_in(const fs::path& file) {
  pid_t pid = 0;
  eventually([&] { return static_cast<bool>(std::ifstream(file) >> pid); });
  return pid;
}

bool alive(pid_t pid) { return kill(pid, 0) == 0; }

}  // namespace

TEST_CASE("a crashed child is named with its reason, and its log holds what it said last") {
  Folder folder;
  Supervisor supervisor;
  supervisor.start(shell(folder, "plant", "exec sleep 60"));
  supervisor.start(shell(folder, "planner", "echo first; echo 'no solution' >&2; kill -SEGV $$"));
  std::optional<ChildExit> end;
  REQUIRE(eventually([&] { return (end = supervisor.poll()).has_value(); }));
  REQUIRE(end->name == "planner");
  REQUIRE(end->reason.find("signal 11") != std::string::npos);
  REQUIRE(tail(end->log, 1) == "no solution\n");
  REQUIRE(supervisor.running() == 1);
}

TEST_CASE("an exit that nobody asked for is reported with its status") {
  Folder folder;
  Supervisor supervisor;
  supervisor.start(shell(folder, "vision", "exit 2"));
  std::optional<ChildExit> end;
  REQUIRE(eventually([&] { return (end = supervisor.poll()).has_value(); }));
  REQUIRE(end->reason == "exited with status 2");
}

TEST_CASE("a child without a log says it where its parent does") {
  Folder folder;
  const fs::path said = folder.path() / "said";
  const int ours = dup(STDERR_FILENO);
  const int file = open(said.c_str(), O_WRONLY | O_CREAT, 0600);
  dup2(file, STDERR_FILENO);
  Supervisor supervisor;
  supervisor.start({"planner", {"/bin/bash", "-c", "echo 'half way' >&2"}, {}});
  dup2(ours, STDERR_FILENO);
  close(ours);
  close(file);
  REQUIRE(eventually([&] { return supervisor.poll().has_value(); }));
  CHECK(tail(said, 1) == "half way\n");
}

TEST_CASE("stop asks with SIGTERM first, and a child that obeys ends in its own way") {
  Folder folder;
  Supervisor supervisor;
  const fs::path ready = folder.path() / "ready", mark = folder.path() / "mark";
  supervisor.start(shell(folder, "plant",
                         "trap 'touch " + mark.string() + "; exit 0' TERM; touch " +
                             ready.string() + "; while :; do sleep 0.01; done"));
  REQUIRE(eventually([&] { return fs::exists(ready); }));
  REQUIRE(supervisor.stop().empty());
  REQUIRE(fs::exists(mark));
}

TEST_CASE(
    "a child that ignores SIGTERM is killed after the grace, with everything that it started") {
  Folder folder;
  Supervisor supervisor;
  const fs::path pids = folder.path() / "pid";
  supervisor.start(shell(
      folder, "planner",
      "trap '' TERM; sleep 60 & echo $! > " + pids.string() + "; while :; do sleep 0.01; done"));
  const pid_t grandchild = pid_in(pids);
  REQUIRE(alive(grandchild));
  REQUIRE(supervisor.stop(0.2) == std::vector<std::string>{"planner"});
  REQUIRE(eventually([&] { return !alive(grandchild); }));
}

TEST_CASE("the children die with a supervisor that is killed") {
  Folder folder;
  const fs::path pids = folder.path() / "pid";
  const pid_t supervising = fork();
  if (supervising == 0) {
    Supervisor supervisor;
    supervisor.start(
        shell(folder, "plant",
              "echo $$ > " + pids.string() + "; trap '' TERM; while :; do sleep 0.01; done"));
    pause();
    _exit(0);
  }
  const pid_t child = pid_in(pids);
  REQUIRE(alive(child));
  kill(supervising, SIGKILL);
  waitpid(supervising, nullptr, 0);
  REQUIRE(eventually([&] { return !alive(child); }));
}

TEST_CASE("a program that does not exist is named at the start") {
  Folder folder;
  Supervisor supervisor;
  REQUIRE_THROWS_WITH(
      supervisor.start({"vision", {"/nowhere/c3rt-vision"}, folder.path() / "vision.log"}),
      "vision: cannot start /nowhere/c3rt-vision: No such file or directory");
  REQUIRE(supervisor.running() == 0);
}
