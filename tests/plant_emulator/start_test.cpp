#include "plant_emulator/start.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

namespace c3rt::plant {
namespace {

Parameters two_balls(double first_spread, double second_spread) {
  Parameters parameters{};
  parameters.world.balls = {{{0.55, 0.1}, 0.0315, 0.132, false, first_spread},
                            {{0.45, -0.1}, 0.0315, 0.132, false, second_spread}};
  return parameters;
}

Eigen::Vector2d offset(const Parameters& parameters, std::uint64_t seed, std::size_t ball) {
  return drawn_start(parameters, seed).world.balls[ball].position -
         parameters.world.balls[ball].position;
}

TEST_CASE("without a spread a ball starts where the scenario says, bit by bit") {
  const Parameters parameters = two_balls(0.0, 0.01);
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    CHECK(drawn_start(parameters, seed).world.balls[0].position == Eigen::Vector2d(0.55, 0.1));
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

TEST_CASE("drawn friction lies between its bounds, is the ball's alone, and leaves the tilt") {
  World world{};
  world.friction = {1.0, 1.0, 0.7, 0.8};
  world.table_tilt = {0.005, 0.0};
  world.tilt_drawn = true;
  World drawn = world;
  drawn.friction_drawn = Eigen::Vector2d(0.3, 1.2);
  double least = 2.0, most = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const World table = drawn_table(drawn, seed);
    for (const double mu : {table.friction.ball_table, table.friction.ball_end_effector}) {
      least = std::min(least, mu);
      most = std::max(most, mu);
    }
    REQUIRE(table.friction.ball_table != table.friction.ball_end_effector);
    REQUIRE(table.friction.ball_ball == 0.7);
    REQUIRE(table.friction.end_effector_table == 0.8);
    REQUIRE(table.table_tilt == drawn_table(world, seed).table_tilt);
  }
  CHECK((least >= 0.3 && least < 0.32));
  CHECK((most <= 1.2 && most > 1.18));
}

}  // namespace
}  // namespace c3rt::plant
