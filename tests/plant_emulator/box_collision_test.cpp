#include "plant_emulator/box_collision.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>
#include <mujoco/mujoco.h>

#include "controller/scene/distance.hpp"
#include "plant_emulator/scene.hpp"

using namespace c3rt;

namespace {

constexpr double kHalf = 0.03;

struct Pose {
  std::array<double, 3> p;
  std::array<double, 4> q;
};

/// Two cubes with nothing else, in MuJoCo.
class Cubes {
 public:
  Cubes() {
    model_ = plant::compile_model(
        "<mujoco><worldbody>"
        "<body name='a'><freejoint/><geom type='box' size='.03 .03 .03' mass='.2'/></body>"
        "<body name='b'><freejoint/><geom type='box' size='.03 .03 .03' mass='.2'/></body>"
        "</worldbody></mujoco>");
    data_.reset(mj_makeData(model_.get()));
  }

  /// The depth of the deepest contact; 0 without any.
  double deepest(const Pose& a, const Pose& b) {
    put(0, a);
    put(1, b);
    mj_kinematics(model_.get(), data_.get());
    mj_collision(model_.get(), data_.get());
    double deepest = 0.0;
    for (int i = 0; i < data_->ncon; ++i) deepest = std::max(deepest, -data_->contact[i].dist);
    return deepest;
  }

 private:
  void put(int body, const Pose& pose) {
    double* q = data_->qpos + 7 * body;
    std::copy(pose.p.begin(), pose.p.end(), q);
    std::copy(pose.q.begin(), pose.q.end(), q + 3);
  }
  plant::Model model_;
  plant::Data data_;
};

double overlap(const Pose& a, const Pose& b) {
  const auto place = [](const Pose& pose) {
    const Eigen::Quaterniond q(pose.q[0], pose.q[1], pose.q[2], pose.q[3]);
    return scene::Place{Eigen::Vector3d(pose.p[0], pose.p[1], pose.p[2]),
                        q.normalized().toRotationMatrix()};
  };
  const scene::Shape cube = scene::Shape::box({kHalf, kHalf, kHalf});
  return -scene::separation(cube, place(a), cube, place(b)).distance;
}

// As two cubes lay in a run before they flew apart: a corner of one just at a face of the other.
const Pose kFirst{{0.600179074, -0.165985768, 0.00549890697}, {0.907863115, 0, 0, 0.419266698}};
const Pose kSecond{{0.527134485, -0.167836271, 0.00549890697}, {0.797994425, 0, 0, 0.60266483}};

}  // namespace

TEST_CASE("boxes: two that stand upright and just touch do not overlap in the plant") {
  Cubes cubes;
  std::mt19937 draw(1);
  std::normal_distribution<double> last_digits(0.0, 1e-9);
  for (int i = 0; i < 20000; ++i) {
    Pose a = kFirst, b = kSecond;
    for (Pose* pose : {&a, &b}) {
      for (double& value : pose->p) value += last_digits(draw);
      for (double& value : pose->q) value += last_digits(draw);
    }
    REQUIRE(cubes.deepest(a, b) < 1e-5);
  }
}

TEST_CASE("boxes: those that overlap are as deep in each other as they are") {
  Cubes cubes;
  std::mt19937 draw(2);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  int overlapping = 0;
  for (int i = 0; i < 5000; ++i) {
    const double yaw = M_PI * part(draw), tilt = 0.1 * part(draw);
    const Pose a{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
    const Pose b{{0.06 + 0.02 * part(draw), 0.03 * part(draw), 0.005 * part(draw)},
                 {std::cos(yaw / 2) * std::cos(tilt / 2), std::cos(yaw / 2) * std::sin(tilt / 2),
                  std::sin(yaw / 2) * std::sin(tilt / 2), std::sin(yaw / 2) * std::cos(tilt / 2)}};
    const double truth = overlap(a, b);
    if (truth < 0.0) {
      CHECK(cubes.deepest(a, b) == 0.0);
    } else {
      ++overlapping;
      // a face that lies askew on another one has points that are deeper than it has to be moved
      CHECK(cubes.deepest(a, b) < 1.01 * truth + 1e-3);
      if (truth > 1e-3) CHECK(cubes.deepest(a, b) > 0.3 * truth);
    }
  }
  CHECK(overlapping > 500);
}
