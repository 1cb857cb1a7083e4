// The table from above: each thing's pixels lie where the thing does.
#include "plant_emulator/top_view.hpp"

#include <cstddef>

#include <catch2/catch.hpp>

#include "tests/plant_emulator/parameters.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

constexpr int kWidth = 150, kHeight = 100;  // [px]
constexpr double kPixel = 0.004;            // [m]
const Eigen::AlignedBox2d kShown{Eigen::Vector2d(0.35, -0.3), Eigen::Vector2d(0.75, 0.3)};

/// Pixels of this colour, and the middle of them in W [m].
struct Seen {
  int pixels = 0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
};
template <typename IsOne>
Seen seen(const std::vector<std::uint8_t>& picture, const IsOne& is_one) {
  Seen out;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const auto at = static_cast<std::size_t>(3 * (row * kWidth + column));
      if (!is_one(picture[at], picture[at + 1], picture[at + 2])) continue;
      ++out.pixels;
      out.middle += kShown.max() - kPixel * Eigen::Vector2d(row + 0.5, column + 0.5);
    }
  }
  out.middle /= out.pixels;
  return out;
}

TEST_CASE("top view: ball and end effector are seen from above where they are, the arm is not") {
  const Plant plant(test_parameters());
  const std::vector<std::uint8_t> picture = top_view(plant, kShown, kWidth, kHeight);
  REQUIRE(picture.size() == std::size_t{3} * kWidth * kHeight);

  const Seen ball = seen(picture, [](int red, int, int blue) { return red > 200 && blue < 100; });
  CHECK((ball.middle - Eigen::Vector2d(0.55, 0.1)).norm() < 0.5 * kPixel);
  const double area = M_PI * 0.0315 * 0.0315;
  CHECK(ball.pixels * kPixel * kPixel == Approx(area).epsilon(0.05));

  const Seen effector =
      seen(picture, [](int red, int green, int blue) { return red + green + blue < 200; });
  CHECK((effector.middle - plant.state().p_WE.head<2>()).norm() < 0.5 * kPixel);

  const Seen table = seen(picture, [](int red, int green, int blue) {
    return red == 219 && green == 221 && blue == 224;  // 0.86 0.87 0.88
  });
  CHECK(table.pixels + ball.pixels + effector.pixels == kWidth * kHeight);
}

}  // namespace
