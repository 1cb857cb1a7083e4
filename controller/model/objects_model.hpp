#pragma once
// Any rigid objects on a table that a point-mass end effector with a spherical tip pushes.
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "controller/model/registry.hpp"
#include "controller/scene/object.hpp"

namespace c3rt::model {

struct ObjectsParameters {
  double end_effector_mass;      // [kg]; a planning parameter, not the arm's
  double end_effector_radius;    // [m]
  double table_height;           // of the table's surface in W [m]
  double friction_end_effector;  // μ between end effector and any object
  double friction_table;         // μ between table and any object
  double friction_objects;       // μ between two objects
  int support_points;            // of each object with the table, 3 or 4
  bool each_object;  // the end effector has a contact with each object; else with the nearest alone
  std::vector<scene::Object> objects;  // 1 to 4
  // Of those so many are in the model, 0: all. The one that is nearest to the end effector, and
  // those whose centres of mass are nearest to its; the others stay where they are.
  int closest = 0;
  // of the objects' motion: with 1/Δt they forget from step to step how they moved, and move only
  // as far as they are pushed [1/s]
  double damping = 0.0;
};

/// x = [q; v], q = [p_WE; p_WB, θ of each object], v = [v_WE; v_WB, ω_WB of each], u = force on the
/// end effector [N], where the objects are those that are in the model, in their order. θ is the
/// rotation vector in W from the orientation about which the model is taken: 0 of that scene
/// itself. The only place that knows the order.
struct ObjectsLayout {
  static constexpr int n_u = 3, n_e = 4;
  int objects;

  int n_v() const noexcept { return 3 + 6 * objects; }
  int n_x() const noexcept { return 2 * n_v(); }
  static constexpr int effector = 0;  // in q and in v
  static constexpr int position(int object) noexcept { return 3 + 6 * object; }
  static constexpr int rotation(int object) noexcept { return 6 + 6 * object; }
};

/// The contacts, in their order: the end effector with the nearest point of the nearest object (or
/// of each object); each object's support points with the table, those of the face that looks down
/// the most; and every two objects where they are nearest. Gravity acts on the objects; the arm
/// carries the end effector. The table's edges are turned by 22.5 degrees from point to point, as
/// four edges that are aligned at all points resist no rotation while an object slides along one.
/// @throws std::invalid_argument for another number of objects or support points
std::unique_ptr<PlanningModel> make_objects_model(const ObjectsParameters& parameters);
ModelKind mjcf_kind();

}  // namespace c3rt::model
