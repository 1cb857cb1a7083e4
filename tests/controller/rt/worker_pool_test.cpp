#include "controller/rt/worker_pool.hpp"

#include <array>
#include <atomic>

#include <catch2/catch.hpp>

using c3rt::rt::WorkerPool;

namespace {

struct Counts {
  std::array<std::atomic<int>, 100> done{};
  std::array<std::atomic<int>, 4> inside{};
  std::atomic<int> overlaps{0};

  static void task(void* context, int index, int worker) noexcept {
    Counts& counts = *static_cast<Counts*>(context);
    if (counts.inside[static_cast<std::size_t>(worker)]++ != 0) ++counts.overlaps;
    ++counts.done[static_cast<std::size_t>(index)];
    --counts.inside[static_cast<std::size_t>(worker)];
  }
};

}  // namespace

TEST_CASE("worker pool: every index is done once, no worker does two at a time") {
  for (const int workers : {1, 2, 4}) {
    WorkerPool pool(workers);
    REQUIRE(pool.workers() == workers);
    Counts counts;
    for (int round = 0; round < 200; ++round) {
      WorkerPool::run_on(&pool, 100, &Counts::task, &counts);
      for (const auto& done : counts.done) CHECK(done == round + 1);
    }
    CHECK(counts.overlaps == 0);
  }
}

TEST_CASE("worker pool: nothing to do returns at once") {
  WorkerPool pool(3);
  Counts counts;
  pool.run(0, &Counts::task, &counts);
  for (const auto& done : counts.done) CHECK(done == 0);
}
