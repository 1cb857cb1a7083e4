#include "vision/tag/joint_fit.hpp"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "controller/base/random.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::vision;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kNoise = 0.2;  // [px]
constexpr JointFitParameters kParameters{kNoise, 1.0};

std::vector<CameraModel> three_cameras() {
  std::vector<CameraModel> cameras;
  for (const Vector3d& p :
       {Vector3d(1.2, 0, 0.7), Vector3d(0.45, 0.75, 0.75), Vector3d(0.45, -0.75, 0.75)}) {
    Isometry3d X_WC = Isometry3d::Identity();
    X_WC.linear() = look_at(p, {0.55, 0, 0.03});
    X_WC.translation() = p;
    cameras.push_back(centred_camera(1280, 960, 0.8, X_WC));
  }
  return cameras;
}

scene::Tag tag(int id, const Vector3d& p_BT, const Matrix3d& R_BT = Matrix3d::Identity()) {
  return {id, 0.032, p_BT, R_BT};
}

/// On the top of a T.
std::vector<scene::Tag> flat_tags() {
  return {tag(0, {-0.06, 0, 0.02}), tag(1, {-0.02, 0, 0.02}), tag(2, {0.02, 0, 0.02}),
          tag(3, {0.06, 0, 0.02}),  tag(4, {0, -0.04, 0.02}), tag(5, {0, -0.08, 0.02})};
}

/// On five sides of a box.
std::vector<scene::Tag> box_tags() {
  std::vector<scene::Tag> tags{tag(0, {0, 0, 0.03})};
  for (int side = 0; side < 4; ++side) {
    const Matrix3d turn = Eigen::AngleAxisd(side * M_PI_2, Vector3d::UnitZ()).toRotationMatrix();
    Matrix3d R;  // y up, z out along x
    R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    tags.push_back(tag(1 + side, turn * Vector3d(0.04, 0, 0.0), turn * R));
  }
  return tags;
}

Isometry3d pose(double x, double y, double z, double yaw, double tilt = 0.0) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() =
      (Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt, Vector3d::UnitX()))
          .toRotationMatrix();
  X.translation() << x, y, z;
  return X;
}

/// What the cameras see of tags that are turned to them; noise [px].
std::vector<TagView> see(const std::vector<CameraModel>& cameras,
                         const std::vector<scene::Tag>& tags, const Isometry3d& X_WB,
                         double noise = 0.0, std::uint64_t seed = 1) {
  base::Random random(seed);
  std::vector<TagView> views;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Isometry3d X_CB = cameras[c].X_WC.inverse() * X_WB;
    for (const scene::Tag& t : tags) {
      const Vector3d normal = X_CB.linear() * t.R_BT.col(2), middle = X_CB * t.p_BT;
      if (normal.dot(middle.normalized()) > -0.3) continue;
      TagView view{static_cast<int>(c), t, {}};
      const auto corners = tag_corners(t);
      for (std::size_t k = 0; k < 4; ++k) {
        view.seen[k] = project(cameras[c], X_CB * corners[k]) +
                       noise * Vector2d(random.normal(), random.normal());
      }
      views.push_back(view);
    }
  }
  return views;
}

/// (δp, δθ) from one pose to another, along W's axes.
Vector6 difference(const JointFit& fit, const Isometry3d& X_WB) {
  const Eigen::AngleAxisd turn(fit.q_WB.toRotationMatrix() * X_WB.linear().transpose());
  Vector6 e;
  e << fit.p_WB - X_WB.translation(), turn.angle() * turn.axis();
  return e;
}

}  // namespace

TEST_CASE("joint fit: exact corners give the exact pose, from near, from far and from nothing") {
  const auto cameras = three_cameras();
  const Isometry3d X_WB = pose(0.5, 0.1, 0.01, 2.5);
  for (const auto& tags : {flat_tags(), box_tags()}) {
    const auto views = see(cameras, tags, X_WB);
    for (const std::optional<Isometry3d>& expected :
         {std::optional<Isometry3d>(pose(0.49, 0.11, 0.012, 2.4)),
          std::optional<Isometry3d>(pose(0.3, -0.2, 0.0, -1.0)), std::optional<Isometry3d>()}) {
      const JointFit fit = fit_pose(cameras, views, expected, kParameters);
      REQUIRE(fit.found);
      CHECK(fit.views_used == static_cast<int>(views.size()));
      CHECK(difference(fit, X_WB).norm() < 1e-8);
    }
  }
}

TEST_CASE("joint fit: one camera alone is enough, any pose, many starts (property)") {
  const auto all = three_cameras();
  for (int i = 0; i < c3rt::test::property_instances(); ++i) {
    support::Random random(static_cast<unsigned>(i));
    const Isometry3d X_WB =
        pose(0.55 + 0.2 * random.uniform(), 0.25 * random.uniform(), 0.02, M_PI * random.uniform());
    const std::vector<CameraModel> one{all[static_cast<std::size_t>(random.index(3))]};
    const auto views = see(one, flat_tags(), X_WB, 0.1, static_cast<std::uint64_t>(i));
    const JointFit fit = fit_pose(one, views, std::nullopt, kParameters);
    CAPTURE(i);
    REQUIRE(fit.found);
    const Vector6 e = difference(fit, X_WB);
    CHECK(e.head<3>().norm() < 0.01);
    CHECK(e.tail<3>().norm() < 0.1);
  }
}

TEST_CASE("joint fit: the covariance of a square seen straight on is the closed form") {
  // u = f x / z: of 8 coordinates each has |∂u/∂z| = f h / d², |∂u/∂θ_z| = f h / d
  Isometry3d X_WC = Isometry3d::Identity();
  X_WC.linear() = Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix();  // looks down
  const double d = 0.8, h = 0.016;
  X_WC.translation().z() = d;
  const std::vector<CameraModel> cameras{centred_camera(1280, 960, 0.8, X_WC)};
  const auto views = see(cameras, {tag(0, Vector3d::Zero())}, Isometry3d::Identity());
  REQUIRE(views.size() == 1);
  const JointFit fit = fit_pose(cameras, views, pose(0.001, 0, 0.01, 0.05, 0.02), kParameters);
  REQUIRE(fit.found);
  const double f = cameras[0].fx;
  CHECK(std::sqrt(fit.covariance(2, 2)) == Approx(kNoise * d * d / (f * h * std::sqrt(8.0))));
  CHECK(std::sqrt(fit.covariance(5, 5)) == Approx(kNoise * d / (f * h * std::sqrt(8.0))));
}

TEST_CASE("joint fit: the covariance is that of finite differences, and errors have it") {
  const auto cameras = three_cameras();
  const auto tags = flat_tags();
  const Isometry3d X_WB = pose(0.55, -0.1, 0.005, 0.7);
  const auto exact = see(cameras, tags, X_WB);
  const JointFit fit = fit_pose(cameras, exact, X_WB, kParameters);

  Matrix6 H = Matrix6::Zero();
  constexpr double kStep = 1e-6;
  const auto moved = [&](int i, double by) {
    Isometry3d X = X_WB;
    if (i < 3) X.translation()[i] += by;
    if (i >= 3) X.linear() = Eigen::AngleAxisd(by, Vector3d::Unit(i - 3)) * X_WB.linear();
    return see(cameras, tags, X);
  };
  std::vector<Eigen::VectorXd> columns;
  for (int i = 0; i < 6; ++i) {
    const auto plus = moved(i, kStep), minus = moved(i, -kStep);
    Eigen::VectorXd column(8 * exact.size());
    for (std::size_t v = 0; v < exact.size(); ++v) {
      for (std::size_t k = 0; k < 4; ++k)
        column.segment<2>(8 * v + 2 * k) = (plus[v].seen[k] - minus[v].seen[k]) / (2 * kStep);
    }
    columns.push_back(column);
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) H(i, j) = columns[i].dot(columns[j]);
  }
  const Matrix6 expected = kNoise * kNoise * support::inverse(H);
  CHECK((fit.covariance - expected).norm() < 1e-5 * expected.norm());

  // eᵀ Σ⁻¹ e has the mean 6 and the variance 12
  double sum = 0.0;
  constexpr int kDraws = 400;
  for (int i = 0; i < kDraws; ++i) {
    const auto views = see(cameras, tags, X_WB, kNoise, static_cast<std::uint64_t>(i));
    const Vector6 e = difference(fit_pose(cameras, views, X_WB, kParameters), X_WB);
    sum += e.dot(support::solve_definite(expected, e).col(0));
  }
  CHECK(std::abs(sum / kDraws - 6.0) < 4.0 * std::sqrt(12.0 / kDraws));
}

TEST_CASE("joint fit: tags of another size or place are outliers and leave the pose alone") {
  const auto cameras = three_cameras();
  const Isometry3d X_WB = pose(0.6, 0.05, 0.02, -2.0);
  auto printed = flat_tags();
  printed[1].size = 0.028;       // smaller than its file says
  printed[4].p_BT.x() += 0.004;  // elsewhere
  auto views = see(cameras, printed, X_WB, 0.05);
  for (TagView& view : views) view.tag = flat_tags()[static_cast<std::size_t>(view.tag.id)];
  for (const std::optional<Isometry3d>& expected :
       {std::optional<Isometry3d>(X_WB), std::optional<Isometry3d>()}) {
    const JointFit fit = fit_pose(cameras, views, expected, kParameters);
    REQUIRE(fit.found);
    CHECK(fit.views_used == static_cast<int>(views.size()) - 6);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const int id = views[i].tag.id;
      CHECK(fit.used[i] == (id != 1 && id != 4));
    }
    CHECK(difference(fit, X_WB).norm() < 1e-3);
    const auto size = [&](const TagView& view) {
      Isometry3d X(fit.q_WB);
      X.translation() = fit.p_WB;
      return *seen_size(cameras[static_cast<std::size_t>(view.camera)], view, X);
    };
    for (const TagView& view : views) {
      if (view.tag.id == 1) CHECK(size(view) == Approx(0.028).margin(3e-4));
      if (view.tag.id == 4) CHECK(size(view) == Approx(0.032).margin(3e-4));
    }
  }
}

TEST_CASE("joint fit: what is not known is not found") {
  const auto cameras = three_cameras();
  const Isometry3d X_WB = pose(0.55, 0, 0, 0.3);
  CHECK_FALSE(fit_pose(cameras, {}, X_WB, kParameters).found);
  auto views = see(cameras, flat_tags(), X_WB);

  SECTION("one view alone may be tilted the other way: only an expected pose tells") {
    const std::vector<TagView> one{views[0]};
    CHECK_FALSE(fit_pose(cameras, one, std::nullopt, kParameters).found);
    const JointFit fit = fit_pose(cameras, one, pose(0.551, 0, 0, 0.31), kParameters);
    REQUIRE(fit.found);
    CHECK(difference(fit, X_WB).norm() < 1e-6);
    // and its covariance says that little is known
    CHECK(fit.covariance(0, 0) >
          20.0 * fit_pose(cameras, views, X_WB, kParameters).covariance(0, 0));
  }
  SECTION("two tags that contradict each other, seen equally often: neither") {
    auto printed = flat_tags();
    printed.resize(3);
    printed[0].p_BT.x() += 0.01;
    printed[1].p_BT.y() += 0.01;
    auto odd = see({cameras[0]}, printed, X_WB);
    for (TagView& view : odd) view.tag = flat_tags()[static_cast<std::size_t>(view.tag.id)];
    CHECK_FALSE(fit_pose({cameras[0]}, odd, X_WB, kParameters).found);
  }
}
