#include "cli/program.hpp"

#include <chrono>
#include <fstream>

#include <catch2/catch.hpp>
#include <signal.h>

#include "tests/cli/eventually.hpp"
#include "tests/cli/folder.hpp"

using namespace c3rt::cli;
using Kind = ProgramEnd::Kind;

TEST_CASE("program: what it says and how it ends comes back") {
  const ProgramEnd end = run_program({"sh", "-c", "cat; echo bad >&2; exit 3"}, "good\n", 20.0);
  CHECK(end.kind == Kind::kExited);
  CHECK(end.status == 3);
  CHECK(end.output == "good\nbad\n");
  CHECK(end.reason == "exited with status 3");
  CHECK_FALSE(end.ok());
  CHECK(run_program({"true"}, "", 20.0).ok());
}

TEST_CASE("program: what is said of its environment stands in the place of what this one has") {
  setenv("C3RT_TEST_KEPT", "kept", 1);
  setenv("C3RT_TEST_CHANGED", "before", 1);
  const ProgramEnd end =
      run_program({"sh", "-c", "echo $C3RT_TEST_KEPT $C3RT_TEST_CHANGED $C3RT_TEST_CHANGE; env"},
                  "", 20.0, {"C3RT_TEST_CHANGED=after", "C3RT_TEST_CHANGE=other"});
  CHECK_THAT(end.output, Catch::StartsWith("kept after other\n"));
  CHECK_THAT(end.output, !Catch::Contains("before"));
  CHECK_THAT(run_program({"env"}, "", 20.0).output, Catch::Contains("C3RT_TEST_CHANGED=before"));
}

TEST_CASE("program: one that is missing, or that reads nothing of a long input, does no harm") {
  const ProgramEnd missing = run_program({"c3rt-no-such-program"}, std::string(1 << 20, 'x'), 20.0);
  CHECK(missing.kind == Kind::kNotFound);
  CHECK(missing.reason == "is not installed");
  // with a pipe this would have been SIGPIPE
  CHECK(run_program({"true"}, std::string(1 << 20, 'x'), 20.0).ok());
  const ProgramEnd killed = run_program({"sh", "-c", "kill -SEGV $$"}, "", 20.0);
  CHECK(killed.kind == Kind::kSignalled);
  CHECK(killed.reason == "was killed by signal 11 (Segmentation fault)");
}

TEST_CASE("program: one that hangs is killed after its time, with what it started") {
  const Folder folder;
  const auto pids = folder.path() / "pid";
  const ProgramEnd end = run_program(
      {"sh", "-c", "trap '' TERM; sleep 300 & echo $! > " + pids.string() + "; wait"}, "", 0.5);
  CHECK(end.kind == Kind::kTimedOut);
  CHECK(end.reason == "did not end within 0.5 s");
  pid_t grandchild = 0;
  if (std::ifstream(pids) >> grandchild)  // not where the machine was too slow to start it
    CHECK(eventually([&] { return kill(grandchild, 0) != 0; }));
}

TEST_CASE("program: one that talks without end is cut") {
  const ProgramEnd end = run_program({"sh", "-c", "head -c 3000000 /dev/zero"}, "", 20.0);
  CHECK(end.ok());
  CHECK(end.output.size() >= 1U << 20);
  CHECK(end.output.size() < 1200000);
}
