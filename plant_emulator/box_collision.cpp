#include "plant_emulator/box_collision.hpp"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>
#include <mujoco/mujoco.h>

namespace c3rt::plant {
namespace {

using Axes = Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>>;
using Point = Eigen::Map<const Eigen::Matrix<mjtNum, 3, 1>>;

constexpr mjtNum kLooksDeep = 1e-3;  // only contacts deeper than this are looked at [m]
constexpr mjtNum kTooDeep = 1e-3;    // than the boxes overlap [m]
constexpr mjtNum kParallel = 1e-6;   // edges whose product is shorter give no axis

mjfCollision of_boxes = nullptr;

/// How far the boxes have to be moved to come apart: the least overlap along the normals of faces
/// and pairs of edges. Negative where they are apart [m].
mjtNum overlap(const mjModel* model, const mjData* data, int first, int second) noexcept {
  const Axes R_1(data->geom_xmat + 9 * first), R_2(data->geom_xmat + 9 * second);
  const Point half_1(model->geom_size + 3 * first), half_2(model->geom_size + 3 * second);
  const Eigen::Matrix<mjtNum, 3, 1> between =
      Point(data->geom_xpos + 3 * second) - Point(data->geom_xpos + 3 * first);
  mjtNum least = std::numeric_limits<mjtNum>::infinity();
  const auto look = [&](const Eigen::Matrix<mjtNum, 3, 1>& axis) {
    const mjtNum length = axis.norm();
    if (length < kParallel) return;
    const mjtNum reach = (R_1.transpose() * axis).cwiseAbs().dot(half_1) +
                         (R_2.transpose() * axis).cwiseAbs().dot(half_2);
    least = std::min(least, (reach - std::abs(axis.dot(between))) / length);
  };
  for (int i = 0; i < 3; ++i) {
    look(R_1.col(i));
    look(R_2.col(i));
    for (int j = 0; j < 3; ++j) look(R_1.col(i).cross(R_2.col(j)));
  }
  return least;
}

int checked(const mjModel* model, const mjData* data, mjContact* contacts, int first, int second,
            mjtNum margin) {
  const int count = of_boxes(model, data, contacts, first, second, margin);
  const auto depth = [](const mjContact& contact) { return -contact.dist; };
  mjtNum deepest = 0.0;
  for (int i = 0; i < count; ++i) deepest = std::max(deepest, depth(contacts[i]));
  if (deepest < kLooksDeep) return count;
  if (deepest < std::max(0.0, overlap(model, data, first, second)) + kTooDeep) return count;
  return mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_MESH](model, data, contacts, first, second, margin);
}

}  // namespace

void check_box_collisions() noexcept {
  static const bool once = [] {
    of_boxes = mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_BOX];
    mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_BOX] = checked;
    return true;
  }();
  static_cast<void>(once);
}

}  // namespace c3rt::plant
