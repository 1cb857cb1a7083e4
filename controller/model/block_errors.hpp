#pragma once
// How far an LCS is from finite differences of the step that it stands for.
#include <vector>

#include <Eigen/Core>

#include "controller/model/contact_model.hpp"
#include "controller/model/mechanism_model.hpp"
#include "controller/model/planning_model.hpp"

namespace c3rt::model {

/// The largest error of each block over its largest entry; of d and c that of x⁺ and η where the
/// LCS is made, without u and λ [mixed units]. A block of nothing but zeros has the error itself.
struct BlockErrors {
  double A, B, D, d, E, F, H, c;
};

/// A scene after its bodies have moved with these velocities for a time; their velocities stay.
/// @param v [v_WE; v_WB, ω_WB of each body]
scene::Scene moved(const scene::Scene& scene, const Eigen::VectorXd& v, double time);

/// Of a model whose coordinates are q = [p_WE; p_WB, θ of each body] and v as in `moved`. The step:
/// v⁺ with f, M and all contact Jacobians where it begins, then every body moves with v⁺ for Δt;
/// gaps are those of the bodies where it begins and close with v⁺.
/// @param dt time step Δt [s]
BlockErrors block_errors(const PlanningModel& model, ContactModel contact_model,
                         const scene::Scene& scene, const std::vector<int>& contacts, double dt);
/// The same of a mechanism: v⁺ with f, M and all contact Jacobians at x, then every coordinate
/// moves with v⁺ for Δt, rotations on SO(3).
BlockErrors block_errors(const MechanismModel& model, const Eigen::VectorXd& x, double dt);

}  // namespace c3rt::model
