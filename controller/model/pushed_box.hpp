#pragma once
// A box on a table that a point-mass end effector with a spherical tip pushes.
#include <memory>

#include <Eigen/Core>

#include "controller/model/contact_system.hpp"
#include "controller/model/registry.hpp"

namespace c3rt::model {

struct PushedBoxParameters {
  double end_effector_mass;      // [kg]; a planning parameter, not the arm's
  double end_effector_radius;    // [m]
  double box_mass;               // [kg], of even density
  Eigen::Vector3d half_sizes;    // of the box [m]
  double table_height;           // of the table's surface in W [m]
  double friction_end_effector;  // μ between end effector and box
  double friction_table;         // μ between box and table
};

/// x = [p_WE (3); p_WB (3); θ (3); v_WE (3); v_WB (3); ω_WB (3)], u = force on the end effector
/// [N]. θ is the rotation vector in W from the orientation about which the model is taken: 0 of
/// that scene itself. The only place that knows the order.
struct PushedBoxLayout {
  static constexpr int n_x = 18, n_u = 3, n_v = 9, n_c = 5, n_e = 4;
  static constexpr int p_WE = 0, p_WB = 3, rotation = 6, v_WE = 9, v_WB = 12, omega_WB = 15;
};

/// Gravity acts on the box; the arm carries the end effector. Contact 0 is the end effector with
/// the nearest point of the box, contacts 1 to 4 are the corners of its lower face with the table.
/// The table's edges are turned by 22.5 degrees from corner to corner, as four edges that are
/// aligned at all corners resist no rotation while the box slides along one of them.
std::unique_ptr<PlanningModel> make_pushed_box(const PushedBoxParameters& parameters);
ModelKind pushed_box_kind();

}  // namespace c3rt::model
