#include "plant_emulator/box_collision.hpp"

#include <algorithm>

#include <Eigen/Core>
#include <mujoco/mujoco.h>

#include "controller/scene/distance.hpp"

namespace c3rt::plant {
namespace {

constexpr mjtNum kLooksDeep = 1e-3;  // only contacts deeper than this are looked at [m]
constexpr mjtNum kTooDeep = 1e-3;    // than the boxes overlap [m]

mjfCollision of_boxes = nullptr;

/// How far the boxes have to be moved along a face's normal to come apart; negative where they are
/// apart [m].
mjtNum overlap(const mjModel* model, const mjData* data, int first, int second) noexcept {
  const auto shape = [model](int geom) {
    return scene::Shape::box(Eigen::Map<const Eigen::Vector3d>(model->geom_size + 3 * geom));
  };
  const auto place = [data](int geom) {
    using Axes = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
    return scene::Place{Eigen::Map<const Eigen::Vector3d>(data->geom_xpos + 3 * geom),
                        Eigen::Map<const Axes>(data->geom_xmat + 9 * geom)};
  };
  return -scene::separation(shape(first), place(first), shape(second), place(second)).distance;
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
