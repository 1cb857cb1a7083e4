#include "vision/track/fuse.hpp"

#include <catch2/catch.hpp>

using namespace c3rt::vision;

namespace {

const Eigen::Vector3d kBall(0.55, 0.1, 0.0315);
const FusionParameters kParameters{0.006};

CameraEstimate at(double dx, double dy) { return {true, kBall + Eigen::Vector3d(dx, dy, 0)}; }

}  // namespace

TEST_CASE("fuse: cameras that agree are averaged") {
  const Fusion fusion = fuse({at(0.001, 0), at(-0.001, 0.001), at(0, 0.002)}, kBall, kParameters);
  REQUIRE(fusion.found);
  REQUIRE(fusion.cameras_used == 3);
  REQUIRE((fusion.p_WB - kBall - Eigen::Vector3d(0, 0.001, 0)).norm() < 1e-15);
}

TEST_CASE("fuse: the one of three that disagrees is rejected, whichever it is") {
  for (std::size_t wrong = 0; wrong < 3; ++wrong) {
    std::vector<CameraEstimate> estimates(3, at(0, 0));
    estimates[wrong] = at(0.02, 0);
    // even where the prediction sides with the outlier: two cameras are better evidence
    const Fusion fusion = fuse(estimates, estimates[wrong].p_WB, kParameters);
    REQUIRE(fusion.cameras_used == 2);
    REQUIRE_FALSE(fusion.used[wrong]);
    REQUIRE((fusion.p_WB - kBall).norm() < 1e-15);
  }
}

TEST_CASE(
    "fuse: of two cameras that contradict each other the one near the prediction is believed") {
  const Fusion fusion = fuse({at(0.05, 0), at(0, 0), {}}, kBall, kParameters);
  REQUIRE(fusion.cameras_used == 1);
  REQUIRE(fusion.used[1]);
  REQUIRE(fusion.p_WB == kBall);
}

TEST_CASE("fuse: no camera, no position; one camera alone is used") {
  REQUIRE_FALSE(fuse({{}, {}, {}}, kBall, kParameters).found);
  REQUIRE_FALSE(fuse({}, kBall, kParameters).found);
  const Fusion fusion = fuse({{}, at(0.01, 0), {}}, kBall, kParameters);
  REQUIRE(fusion.found);
  REQUIRE(fusion.cameras_used == 1);
}

TEST_CASE("fuse: rays through a point meet there, and a small error of one moves it little") {
  const Eigen::Vector3d p(0.5, 0.1, 0.03);
  std::vector<c3rt::vision::Ray> rays;
  for (const Eigen::Vector3d& origin :
       {Eigen::Vector3d(1.2, 0, 0.7), Eigen::Vector3d(0.45, 0.75, 0.75),
        Eigen::Vector3d(0.45, -0.75, 0.75)}) {
    rays.push_back({origin, (p - origin).normalized()});
  }
  CHECK((c3rt::vision::meeting_point(rays) - p).norm() < 1e-12);
  rays.resize(2);
  CHECK((c3rt::vision::meeting_point(rays) - p).norm() < 1e-12);
  rays[0].direction = (p + Eigen::Vector3d(0, 0.001, 0) - rays[0].origin).normalized();
  CHECK((c3rt::vision::meeting_point(rays) - p).norm() < 1e-3);
}
