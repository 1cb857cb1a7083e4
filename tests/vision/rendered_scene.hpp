#pragma once
// What the tests on rendered pictures share: a scene on a level table, and an arm that points down
// at a place.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <mujoco/mujoco.h>

#include "plant_emulator/load_parameters.hpp"
#include "vision/load_parameters.hpp"
#include "vision/virtual_cameras.hpp"

namespace c3rt::vision::test {

constexpr double kRadius = 0.0315;
constexpr double kTable = 0.0;
constexpr double kPeriod = 0.0125;  // [s]
inline const Eigen::Vector3d kCentre(0.55, 0.0, kTable + kRadius);

inline Parameters parameters() {
  return load_parameters(config::Document::load(std::string(C3RT_SOURCE_DIRECTORY) +
                                                "/tests/vision/three_cameras.yaml"));
}

inline plant::EndEffector end_effector() {
  return plant::end_effector_of(config::load_robot("panda"));
}

/// One world with a ball for each place.
inline plant::World world(const std::vector<Eigen::Vector2d>& places) {
  plant::World world{};
  world.table_height = kTable;
  world.table_tilt.setZero();
  world.friction = {1, 1};
  world.rolling_friction = 0;
  world.step = 5e-4;
  world.end_effector = end_effector();
  for (std::size_t i = 0; i < places.size(); ++i) {
    plant::ObjectParameters object{};
    object.object = scene::solid("ball" + std::to_string(i), scene::Shape::sphere(kRadius), 0.132);
    object.position = places[i];
    world.objects.push_back(object);
  }
  return world;
}

/// Joint angles that hold the end effector's sphere at a place, pointing down: damped least squares
/// on MuJoCo's model.
class InverseKinematics {
 public:
  InverseKinematics() {
    model_ = plant::build_model({world({{0.55, 0.1}}), {}, 16, 16, 0, ""});
    data_.reset(mj_makeData(model_.get()));
    const std::array<double, 7> start{0, 0.4, 0, -2.222, 0, 2.622, 0};
    std::copy(start.begin(), start.end(), data_->qpos);
    site_ = mj_name2id(model_.get(), mjOBJ_SITE, "end_effector");
  }
  std::array<double, 7> solve(const Eigen::Vector3d& p_WE) {
    using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
    Jacobian linear(3, model_->nv), angular(3, model_->nv);
    for (int iteration = 0; iteration < 30; ++iteration) {
      mj_kinematics(model_.get(), data_.get());
      mj_comPos(model_.get(), data_.get());
      mj_jacSite(model_.get(), data_.get(), linear.data(), angular.data(), site_);
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WE(data_->site_xmat +
                                                                                9 * site_);
      Eigen::Matrix<double, 6, 1> error;
      error << p_WE - Eigen::Map<const Eigen::Vector3d>(data_->site_xpos + 3 * site_),
          R_WE.col(2).cross(-Eigen::Vector3d::UnitZ());
      if (error.norm() < 1e-9) break;
      Eigen::Matrix<double, 6, 7> J;
      J << linear.leftCols(7), angular.leftCols(7);
      const Eigen::Matrix<double, 6, 6> damped =
          J * J.transpose() + 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
      const Eigen::Matrix<double, 7, 1> dq = J.transpose() * damped.ldlt().solve(error);
      for (int i = 0; i < 7; ++i) data_->qpos[i] += dq[i];
    }
    std::array<double, 7> q{};
    std::copy(data_->qpos, data_->qpos + 7, q.begin());
    reached_ = Eigen::Map<const Eigen::Vector3d>(data_->site_xpos + 3 * site_);
    return q;
  }
  const Eigen::Vector3d& reached() const { return reached_; }

 private:
  plant::Model model_;
  plant::Data data_;
  int site_ = 0;
  Eigen::Vector3d reached_ = Eigen::Vector3d::Zero();
};

inline double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

}  // namespace c3rt::vision::test
