#include "plant_emulator/pushes.hpp"

#include <array>

#include <catch2/catch.hpp>

using namespace c3rt::plant;

namespace {

const PushParameters kPushes{8, 10.0, 90.0, 0.005, 0.01};

}  // namespace

TEST_CASE("pushes: each is in the first half of its piece of the time, within the sizes, level") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<Push> pushes = drawn_pushes(kPushes, 3, seed);
    REQUIRE(pushes.size() == 8);
    for (int i = 0; i < 8; ++i) {
      const Push& push = pushes[static_cast<std::size_t>(i)];
      CHECK(push.time >= 10.0 + 10.0 * i);
      CHECK(push.time <= 15.0 + 10.0 * i);
      CHECK(push.object >= 0);
      CHECK(push.object < 3);
      CHECK(push.impulse.norm() >= 0.005 - 1e-12);
      CHECK(push.impulse.norm() <= 0.01 + 1e-12);
      CHECK(push.impulse.z() == 0.0);
    }
  }
}

TEST_CASE("pushes: a seed's are the same every time, another seed's are others") {
  const auto first = drawn_pushes(kPushes, 1, 5), again = drawn_pushes(kPushes, 1, 5),
             other = drawn_pushes(kPushes, 1, 6);
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].time == again[i].time);
    CHECK(first[i].impulse == again[i].impulse);
    CHECK(first[i].time != other[i].time);
  }
  CHECK(drawn_pushes({}, 1, 5).empty());
}

TEST_CASE("pushes: over many seeds they come from all sides and to all balls") {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::array<int, 2> balls{};
  constexpr int kSeeds = 500;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const Push& push : drawn_pushes(kPushes, 2, seed)) {
      sum += push.impulse.normalized() / (8.0 * kSeeds);
      ++balls.at(static_cast<std::size_t>(push.object));
    }
  }
  // the mean of 4000 unit vectors in random directions is about 1/63 long
  CHECK(sum.norm() < 0.05);
  CHECK(balls[0] == Approx(4 * kSeeds).epsilon(0.1));
}
