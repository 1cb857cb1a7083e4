#include "cli/mesh/tags.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "tests/support/property.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::cli::mesh;
using Eigen::Vector3d;

namespace {

constexpr double kSize = 0.032, kWidth = 0.04;  // of a tag, and with its border

Triangles block(const Vector3d& low, const Vector3d& high) {
  Triangles points;
  for (int i = 0; i < 8; ++i) {
    points.points.emplace_back((i & 1) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
                               (i & 4) != 0 ? high.z() : low.z());
  }
  return hull_of(points, 8);
}

bool overlap(const Vector3d& a, const Vector3d& b) {
  return (a - b).head<2>().lpNorm<Eigen::Infinity>() < kWidth - 1e-3;
}

}  // namespace

TEST_CASE("tags: a block's top takes as many as fit in rows, as far from one side as the other") {
  for (int i = 0; i < test::property_instances(); ++i) {
    CAPTURE(i);
    support::Random random(i);
    const Vector3d low(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 0.0);
    const Vector3d high =
        low + Vector3d(random.uniform(0.02, 0.3), random.uniform(0.02, 0.2), 0.05);
    const Vector3d sizes = high - low;
    const auto fit = [&](int axis) { return std::floor((sizes[axis] + 4e-4) / kWidth); };
    const auto places = tag_places({block(low, high)}, kSize);
    REQUIRE(places.size() == static_cast<std::size_t>(fit(0) * fit(1)));
    Vector3d sum = Vector3d::Zero();
    for (std::size_t a = 0; a < places.size(); ++a) {
      sum += places[a];
      CHECK(places[a].z() == Approx(0.05));
      for (std::size_t b = 0; b < a; ++b) CHECK_FALSE(overlap(places[a], places[b]));
    }
    if (places.empty()) continue;
    const Vector3d middle = sum / static_cast<double>(places.size());
    CHECK((middle - 0.5 * (low + high)).head<2>().norm() < 1e-9);
  }
}

TEST_CASE("tags: none hangs over an edge, and a face askew to the axes has some") {
  // a triangle of 100 mm along x and y
  Triangles points;
  for (const double z : {0.0, 0.03})
    for (const auto& [x, y] : {std::pair(0.0, 0.0), std::pair(0.1, 0.0), std::pair(0.0, 0.1)})
      points.points.emplace_back(x, y, z);
  const auto places = tag_places({hull_of(points, 6)}, kSize);
  REQUIRE_FALSE(places.empty());
  for (const Vector3d& place : places)
    CHECK(place.x() + place.y() + kWidth <= 0.1 + 1e-3);  // its outer corner is inside
  // two need 80 mm along one side, where the triangle is 20 mm wide
  CHECK(places.size() == 1);
}

TEST_CASE("tags: what lies under another piece, or leans, has none") {
  const Triangles low = block({0, 0, 0}, {0.12, 0.04, 0.04}),
                  above = block({0.0, 0.0, 0.04}, {0.04, 0.04, 0.08});
  const auto places = tag_places({low, above}, kSize);
  REQUIRE(places.size() == 3);
  int on_top = 0;
  for (const Vector3d& place : places) {
    on_top += place.z() > 0.06 ? 1 : 0;
    if (place.z() < 0.06) CHECK(place.x() > 0.05);
  }
  CHECK(on_top == 1);
  Triangles wedge;
  for (const double y : {0.0, 0.1})
    for (const auto& [x, z] : {std::pair(0.0, 0.0), std::pair(0.1, 0.0), std::pair(0.0, 0.1)})
      wedge.points.emplace_back(x, y, z);
  CHECK(tag_places({hull_of(wedge, 6)}, kSize).empty());
}
