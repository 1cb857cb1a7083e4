#include "controller/rt/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::rt;

namespace {

// half a bucket: 1/64 of an octave's width, relative to its lower end, halved
constexpr double kResolution = 0.5 / 64 + 1e-12;

double nearest_rank(const std::vector<double>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[rank - 1];
}

TEST_CASE("Statistics: quantiles agree with those of the sorted samples to within half a bucket") {
  std::mt19937 generator(7);
  std::lognormal_distribution<double> duration(std::log(2e-4), 1.5);
  Statistics statistics;
  std::vector<double> samples;
  for (int i = 0; i < 20'000; ++i) {
    samples.push_back(duration(generator));
    statistics.add(samples.back());
  }
  std::sort(samples.begin(), samples.end());
  const Quantiles quantiles = statistics.snapshot();
  CHECK(quantiles.count == samples.size());
  CHECK(quantiles.p50_s == Approx(nearest_rank(samples, 0.5)).epsilon(kResolution));
  CHECK(quantiles.p95_s == Approx(nearest_rank(samples, 0.95)).epsilon(kResolution));
  CHECK(quantiles.p99_s == Approx(nearest_rank(samples, 0.99)).epsilon(kResolution));
  CHECK(quantiles.p999_s == Approx(nearest_rank(samples, 0.999)).epsilon(kResolution));
  CHECK(quantiles.max_s == samples.back());
}

TEST_CASE("Statistics: nothing added is all zero, and one sample is every quantile") {
  Statistics statistics;
  CHECK(statistics.snapshot().count == 0);
  CHECK(statistics.snapshot().p999_s == 0.0);
  statistics.add(1e-3);
  const Quantiles quantiles = statistics.snapshot();
  CHECK(quantiles.count == 1);
  CHECK(quantiles.p50_s == Approx(1e-3).epsilon(kResolution));
  CHECK(quantiles.p999_s == Approx(1e-3).epsilon(kResolution));
  CHECK(quantiles.max_s == 1e-3);
}

TEST_CASE("Statistics: what no clock can measure is counted and breaks nothing") {
  Statistics statistics;
  for (const double odd : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), 1e-15, 1e9,
                           std::numeric_limits<double>::denorm_min()}) {
    statistics.add(odd);
  }
  const Quantiles quantiles = statistics.snapshot();
  CHECK(quantiles.count == 6);
  CHECK(quantiles.p50_s < 2e-9);
  CHECK(quantiles.max_s == 1e9);
}

TEST_CASE("Statistics: another thread may look while samples are added") {
  constexpr std::uint64_t kSamples = 200'000;
  Statistics statistics;
  std::thread writer([&] {
    for (std::uint64_t i = 0; i < kSamples; ++i) statistics.add(1e-3);
  });
  std::uint64_t previous = 0;
  bool grows = true, sane = true;
  while (previous < kSamples) {
    const Quantiles quantiles = statistics.snapshot();
    grows = grows && quantiles.count >= previous;
    sane = sane && (quantiles.count == 0 || std::abs(quantiles.p50_s - 1e-3) < 1e-5);
    previous = quantiles.count;
  }
  writer.join();
  CHECK(grows);
  CHECK(sane);
}

TEST_CASE("Statistics: add does not allocate") {
  Statistics statistics;
  std::int64_t heap_calls = -1;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 1000; ++i) statistics.add(i * 1e-6);
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
}

}  // namespace
