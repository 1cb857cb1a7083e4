#pragma once
// What Algorithm 3 needs of a simplified model M_s, whatever it is a model of.
#include <memory>

#include <Eigen/Core>

#include "controller/model/contact_system.hpp"
#include "controller/planner/parameters.hpp"
#include "controller/planner/scene.hpp"

namespace c3rt::planner {

constexpr int kEdges = 4;  // of each contact's friction cone

enum class Contacts {
  kPlanned,  // those that the scenario gives L_Δt
  kAll,      // those of the step over Δt_c
};

class PlanningModel {
 public:
  virtual ~PlanningModel() = default;

  virtual int n_x() const noexcept = 0;
  virtual int n_c(Contacts contacts) const noexcept = 0;
  /// Where the end effector's velocity begins in x; its position is at 0.
  virtual int v_WE() const noexcept = 0;

  /// @param x (n_x) is overwritten
  virtual void state(const Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const = 0;
  virtual model::ContactSystem contact_system(const Scene& scene, Contacts contacts) const = 0;

  /// Weights of states, in the order of x, and of what the consensus term weighs contact i with.
  virtual Eigen::VectorXd Q(const PhaseWeights& weights) const = 0;
  struct ContactWeights {
    double normal, tangential;
  };
  virtual ContactWeights G(const PhaseWeights& weights, int contact) const = 0;

  /// What the contacts do to the end effector, in W [N].
  /// @param lambda of Stewart and Trinkle's system with all contacts, unscaled
  virtual Eigen::Vector3d force_on_end_effector(
      const Scene& scene, const Eigen::Ref<const Eigen::VectorXd>& lambda) const = 0;
};

/// M_s of one ball with position and orientation (19 states) [C3, VII-A].
std::unique_ptr<PlanningModel> make_one_ball(const Parameters& parameters);
/// Balls that stay on the table and roll: 14, 18 or 22 states of 2, 3 or 4 [C3, VII-B].
std::unique_ptr<PlanningModel> make_several_balls(const Parameters& parameters);

}  // namespace c3rt::planner
