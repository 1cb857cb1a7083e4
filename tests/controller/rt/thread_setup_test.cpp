#include "controller/rt/thread_setup.hpp"

#include <thread>

#include <catch2/catch.hpp>
#include <pthread.h>
#include <sched.h>

using namespace c3rt;
using namespace c3rt::rt;

namespace {

// in a thread of its own, so that the test's own thread stays ordinary
template <typename F>
void in_thread(F body) {
  std::thread(body).join();
}

TEST_CASE("setup_thread: nothing asked, nothing refused") { CHECK(setup_thread({}).empty()); }

TEST_CASE("setup_thread: what cannot be granted is named in one sentence, and the thread goes on") {
  std::string refused;
  in_thread([&] {
    ThreadSettings settings;
    settings.cpus = {CPU_SETSIZE - 1};  // no machine has this one
    settings.fifo_priority = 1000;      // the scale ends at 99
    refused = setup_thread(settings);
  });
  CHECK_THAT(refused,
             Catch::Contains("CPU affinity " + std::to_string(CPU_SETSIZE - 1) + " refused"));
  CHECK_THAT(refused, Catch::Contains("; SCHED_FIFO priority 1000 refused"));
}

TEST_CASE("setup_thread: a CPU outside of every mask is refused") {
  std::string refused;
  in_thread([&] { refused = setup_thread({0, {-1}, false}); });
  CHECK_THAT(refused, Catch::Contains("CPU affinity -1 refused"));
}

TEST_CASE("setup_thread: the thread is where it was asked to be, unless that was refused") {
  std::string refused;
  int policy = -1, cpu = -1;
  sched_param parameter{};
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  REQUIRE(sched_getaffinity(0, sizeof allowed, &allowed) == 0);
  int first = 0;
  while (!CPU_ISSET(first, &allowed)) ++first;
  in_thread([&] {
    ThreadSettings settings;
    settings.cpus = {first};
    settings.fifo_priority = 10;
    refused = setup_thread(settings);
    pthread_getschedparam(pthread_self(), &policy, &parameter);
    cpu = sched_getcpu();
  });
  CHECK(cpu == first);
  if (refused.empty()) {
    CHECK(policy == SCHED_FIFO);
    CHECK(parameter.sched_priority == 10);
  } else {
    CHECK_THAT(refused, Catch::Contains("SCHED_FIFO priority 10 refused"));
    CHECK(policy == SCHED_OTHER);
  }
}

}  // namespace
