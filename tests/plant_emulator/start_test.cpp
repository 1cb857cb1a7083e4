#include "plant_emulator/start.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "tests/plant_emulator/parameters.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

Parameters two_balls(double first_spread, double second_spread) {
  Parameters parameters{};
  parameters.world.objects = {ball({0.55, 0.1}, 0.0315, 0.132, 0),
                              ball({0.45, -0.1}, 0.0315, 0.132, 1)};
  parameters.world.objects[0].start_spread = first_spread;
  parameters.world.objects[1].start_spread = second_spread;
  return parameters;
}

Eigen::Vector2d offset(const Parameters& parameters, std::uint64_t seed, std::size_t object) {
  return drawn_start(parameters, seed).world.objects[object].position -
         parameters.world.objects[object].position;
}

TEST_CASE("without a spread a ball starts where the scenario says, bit by bit") {
  const Parameters parameters = two_balls(0.0, 0.01);
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    CHECK(drawn_start(parameters, seed).world.objects[0].position == Eigen::Vector2d(0.55, 0.1));
}

TEST_CASE("starts fill the disc of the spread evenly") {
  const Parameters parameters = two_balls(0.01, 0.0);
  constexpr int kDraws = 4000;
  int inner = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const Eigen::Vector2d moved = offset(parameters, seed, 0);
    REQUIRE(moved.norm() <= 0.01);
    sum += moved;
    if (moved.norm() < 0.005) ++inner;  // a quarter of the area
  }
  // five standard deviations: 0.5 / sqrt(n) of the disc's radius, sqrt(0.25 * 0.75 / n)
  CHECK((sum / kDraws).norm() < 5.0 * 0.01 * 0.5 / std::sqrt(1.0 * kDraws));
  CHECK(std::abs(1.0 * inner / kDraws - 0.25) < 5.0 * std::sqrt(0.25 * 0.75 / kDraws));
}

TEST_CASE("a seed draws the same again, and for one ball whatever the other's spread") {
  CHECK(offset(two_balls(0.01, 0.01), 7, 0) == offset(two_balls(0.01, 0.01), 7, 0));
  CHECK(offset(two_balls(0.01, 0.01), 7, 0) != offset(two_balls(0.01, 0.01), 8, 0));
  CHECK(offset(two_balls(0.0, 0.01), 7, 1) == offset(two_balls(0.01, 0.01), 7, 1));
  CHECK(offset(two_balls(0.01, 0.01), 7, 0) != offset(two_balls(0.01, 0.01), 7, 1));
}

TEST_CASE("a drawn tilt has the scenario's size and every direction, the same again for a seed") {
  World world{};
  world.table_tilt = {0.003, -0.004};
  CHECK(drawn_table(world, 3).table_tilt == world.table_tilt);
  world.tilt_drawn = true;
  constexpr int kDraws = 400;
  int quarter[4] = {0, 0, 0, 0};
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const Eigen::Vector2d tilt = drawn_table(world, seed).table_tilt;
    REQUIRE(tilt.norm() == Approx(0.005));
    ++quarter[(tilt.x() > 0.0 ? 1 : 0) + (tilt.y() > 0.0 ? 2 : 0)];
  }
  // five standard deviations of a quarter of the draws
  for (const int count : quarter) CHECK(std::abs(count - kDraws / 4) < 44);
  CHECK(drawn_table(world, 5).table_tilt == drawn_table(world, 5).table_tilt);
}

TEST_CASE("drawn friction lies between its bounds, is the objects' alone, and leaves the tilt") {
  World world{};
  world.objects.push_back(ball({0.55, 0.1}, 0.0315, 0.132));
  world.friction = {0.7, 0.8};
  world.table_tilt = {0.005, 0.0};
  world.tilt_drawn = true;
  World drawn = world;
  drawn.friction_drawn = Eigen::Vector2d(0.3, 1.2);
  double least = 2.0, most = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const World table = drawn_table(drawn, seed);
    for (const double mu :
         {table.objects[0].friction_table, table.objects[0].friction_end_effector}) {
      least = std::min(least, mu);
      most = std::max(most, mu);
    }
    REQUIRE(table.objects[0].friction_table != table.objects[0].friction_end_effector);
    REQUIRE(table.friction.object_object == 0.7);
    REQUIRE(table.friction.end_effector_table == 0.8);
    REQUIRE(table.table_tilt == drawn_table(world, seed).table_tilt);
  }
  CHECK((least >= 0.3 && least < 0.32));
  CHECK((most <= 1.2 && most > 1.18));
}

TEST_CASE("starts fill the rectangle of the spread and turn within the spread of the yaw") {
  Parameters parameters = two_balls(0.0, 0.01);
  const Eigen::Vector2d alone = offset(parameters, 7, 1);
  parameters.world.objects[0].start_spread_xy = {0.1, 0.05};
  parameters.world.objects[0].yaw_spread = 3.0;
  CHECK(offset(parameters, 7, 1) == alone);  // whatever the spread of another
  constexpr int kDraws = 4000;
  int corners = 0, left = 0;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const Eigen::Vector2d moved = offset(parameters, seed, 0).cwiseAbs();
    REQUIRE(moved.x() <= 0.1);
    REQUIRE(moved.y() <= 0.05);
    if (moved.x() > 0.05 && moved.y() > 0.025) ++corners;
    const double yaw = drawn_start(parameters, seed).world.objects[0].yaw;
    REQUIRE(std::abs(yaw) <= 3.0);
    if (yaw > 1.5) ++left;
  }
  // a quarter of the area, and of the angles, with five standard deviations
  CHECK(std::abs(corners - kDraws / 4) < 137);
  CHECK(std::abs(left - kDraws / 4) < 137);
}

}  // namespace
