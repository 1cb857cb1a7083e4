#include "controller/impedance/knots.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::impedance;

namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kStart = 7'000'000'000'000;  // hours into a session

Vector3d random_vector(support::Random& random) {
  return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

/// p(t) = a + b t + c t^2 + d t^3, which a cubic between two knots must give exactly.
struct Cubic {
  Vector3d a, b, c, d;
  Vector3d p(double t) const { return a + t * (b + t * (c + t * d)); }
  Vector3d v(double t) const { return b + t * (2.0 * c + 3.0 * t * d); }
};

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

bool same(const Goal& a, const Goal& b) {
  return a.p_WE == b.p_WE && a.v_WE == b.v_WE && a.q_WE.coeffs() == b.q_WE.coeffs() &&
         a.force_E == b.force_E;
}

}  // namespace

TEST_CASE("knots: between two of them position and velocity are the cubic through both") {
  for (int i = 0; i < c3rt::test::property_instances(); ++i) {
    INFO("instance " << i);
    support::Random random(static_cast<unsigned>(i));
    const Cubic cubic{random_vector(random), random_vector(random), 5.0 * random_vector(random),
                      20.0 * random_vector(random)};
    Knots knots{};
    const int count = 2 + random.index(kMaxKnots - 1);
    std::int64_t time_ns = kStart;
    for (int k = 0; k < count; ++k) {
      Knot& knot = knots[static_cast<std::size_t>(k)];
      knot.time_ns = time_ns;
      knot.p_WE = cubic.p(seconds(time_ns - kStart));
      knot.v_WE = cubic.v(seconds(time_ns - kStart));
      time_ns += kMs + random.index(100) * kMs;
    }
    const std::int64_t end_ns = knots[static_cast<std::size_t>(count - 1)].time_ns;
    for (int s = 0; s < 20; ++s) {
      const auto now_ns = static_cast<std::int64_t>(
          static_cast<double>(end_ns - kStart - 1) * random.uniform(0, 1) + kStart);
      const Goal goal = interpolate(knots, count, now_ns);
      const double t = seconds(now_ns - kStart);
      CHECK((goal.p_WE - cubic.p(t)).norm() < 1e-12 * (1.0 + cubic.p(t).norm()));
      CHECK((goal.v_WE - cubic.v(t)).norm() < 1e-8 * (1.0 + cubic.v(t).norm()));
    }
  }
}

TEST_CASE("knots: orientation turns about one axis at a constant rate, the short way round") {
  const Quaterniond start(AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()));
  const Vector3d axis = Vector3d(-2, 1, 0.5).normalized();
  for (const double sign : {1.0, -1.0}) {  // q and -q are one orientation
    Knots knots{};
    knots[0].time_ns = kStart;
    knots[0].q_WE = start;
    knots[1].time_ns = kStart + 100 * kMs;
    knots[1].q_WE = Quaterniond(AngleAxisd(1.2, axis)) * start;
    knots[1].q_WE.coeffs() *= sign;
    for (int k = 0; k < 100; ++k) {
      const Goal goal = interpolate(knots, 2, kStart + k * kMs);
      const Quaterniond expected = Quaterniond(AngleAxisd(0.012 * k, axis)) * start;
      CHECK(goal.q_WE.angularDistance(expected) < 1e-7);
      CHECK(goal.q_WE.norm() == Approx(1.0).margin(1e-15));
    }
  }
}

TEST_CASE("knots: the force is linear between them") {
  Knots knots{};
  knots[0].time_ns = kStart;
  knots[0].force_E = Vector3d(0, 0, 1);
  knots[1].time_ns = kStart + 10 * kMs;
  knots[1].force_E = Vector3d(5, 0, -1);
  knots[2].time_ns = kStart + 30 * kMs;
  for (int k = 0; k < 10; ++k) {
    const Vector3d expected(0.5 * k, 0, 1.0 - 0.2 * k);
    CHECK((interpolate(knots, 3, kStart + k * kMs).force_E - expected).norm() < 1e-12);
  }
  CHECK((interpolate(knots, 3, kStart + 20 * kMs).force_E - Vector3d(2.5, 0, -0.5)).norm() < 1e-12);
}

TEST_CASE("knots: before the first it is the first, after the last it rests there") {
  Knots knots{};
  for (int k = 0; k < 3; ++k) {
    Knot& knot = knots[static_cast<std::size_t>(k)];
    knot.time_ns = kStart + 10 * k * kMs;
    knot.p_WE = Vector3d(k, 0, 0);
    knot.v_WE = Vector3d(100, 0, 0);
    knot.force_E = Vector3d(0, 0, k);
  }
  const Goal before = interpolate(knots, 3, kStart - 50 * kMs);
  CHECK(before.p_WE == knots[0].p_WE);
  CHECK(before.v_WE == knots[0].v_WE);
  CHECK(same(interpolate(knots, 3, kStart), before));
  for (const std::int64_t late_ns : {std::int64_t{0}, kMs, 80 * kMs}) {
    const Goal after = interpolate(knots, 3, kStart + 20 * kMs + late_ns);
    CHECK(after.p_WE == knots[2].p_WE);
    CHECK(after.v_WE.isZero(0.0));
    CHECK(after.force_E == knots[2].force_E);
  }
}

TEST_CASE("knots: one is followed as it is, at any time") {
  Knots knots{};
  knots[0].time_ns = kStart;
  knots[0].p_WE = Vector3d(0.55, 0.1, 0.12);
  knots[0].v_WE = Vector3d(0.1, -0.2, 0.3);
  knots[0].q_WE = Quaterniond(AngleAxisd(3.0, Vector3d::UnitX()));
  knots[0].force_E = Vector3d(0, 0, -2);
  for (const std::int64_t now_ns : {kStart - 30 * kMs, kStart, kStart + 30 * kMs}) {
    const Goal goal = interpolate(knots, 1, now_ns);
    CHECK(goal.p_WE == knots[0].p_WE);
    CHECK(goal.v_WE == knots[0].v_WE);
    CHECK(goal.q_WE.coeffs() == Quaterniond(knots[0].q_WE).normalized().coeffs());
    CHECK(goal.force_E == knots[0].force_E);
  }
}

TEST_CASE("knots: what is not in order is told") {
  Knots knots{};
  for (int k = 0; k < kMaxKnots; ++k) knots[static_cast<std::size_t>(k)].time_ns = kStart + k;
  CHECK_FALSE(are_ordered(knots, 0));
  CHECK_FALSE(are_ordered(knots, -1));
  CHECK_FALSE(are_ordered(knots, kMaxKnots + 1));
  for (int count = 1; count <= kMaxKnots; ++count) CHECK(are_ordered(knots, count));
  knots[3].time_ns = knots[2].time_ns;
  CHECK(are_ordered(knots, 3));
  CHECK_FALSE(are_ordered(knots, 4));
}

TEST_CASE("knots: interpolate does not allocate") {
  Knots knots{};
  for (int k = 0; k < kMaxKnots; ++k) knots[static_cast<std::size_t>(k)].time_ns = kStart + k * kMs;
  std::int64_t heap_calls = 0;
  {
    const support::AllocationCounter heap;
    for (int k = -1; k < 20; ++k) (void)interpolate(knots, kMaxKnots, kStart + k * kMs + 7);
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
}
