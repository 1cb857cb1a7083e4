#include "cli/soak/proc.hpp"

#include <atomic>
#include <fstream>
#include <thread>

#include <catch2/catch.hpp>
#include <sys/mman.h>
#include <unistd.h>

#include "tests/cli/folder.hpp"

using c3rt::cli::soak::look_at_process;

TEST_CASE("proc: memory, threads, descriptors and log of a process are what they are") {
  const c3rt::cli::Folder folder;
  const auto log = folder.path() / "self.log";
  std::ofstream(log) << std::string(1234, 'x');
  const auto before = look_at_process("self", getpid(), log);
  CHECK(before.name == "self");
  CHECK(before.pid == getpid());
  CHECK(before.log == 1234);
  REQUIRE(before.threads >= 1);

  constexpr std::size_t kBytes = 32 << 20;
  void* const memory = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  REQUIRE(memory != MAP_FAILED);
  std::atomic<bool> stop{false};
  std::thread thread([&stop] {
    while (!stop) std::this_thread::yield();
  });
  const std::ifstream descriptor("/dev/null");
  const auto after = look_at_process("self", getpid(), log);
  stop = true;
  thread.join();
  munmap(memory, kBytes);
  CHECK(after.memory >= before.memory + kBytes - (4u << 20));
  CHECK(after.threads == before.threads + 1);
  CHECK(after.descriptors == before.descriptors + 1);
}

TEST_CASE("proc: a process that is not there has no pid") {
  // the largest pid of Linux is 2^22
  CHECK(look_at_process("nobody", 1 << 23).pid == 0);
}
