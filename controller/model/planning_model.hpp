#pragma once
// A planning model M_s: what a planner needs of it, whatever it is a model of.
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/model/contact_system.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::model {

/// A run of entries of x that carries one weight. Blocks without a name carry none; several blocks
/// may share a name.
struct StateBlock {
  std::string name;
  int start, size;
  int body;  // whose it is; −1: the end effector's
};

/// Two bodies that may touch.
struct ContactPair {
  static constexpr int kEndEffector = -1, kTable = -2;
  int first, second;  // bodies by their index, or one of the above; the normal points to the first
};

/// One contact of a model.
struct ModelContact {
  std::string pair;    // by which a scenario chooses it: "end_effector_ball"
  std::string weight;  // with which its weights begin: "end_effector"
  ContactPair bodies;
};

/// The order of x, u and of the contacts. The only place that knows it.
struct Layout {
  int n_x = 0, n_v = 0, n_u = 0;
  int n_e = 0;  // edges of each contact's friction cone, in opposite pairs
  std::vector<StateBlock> x;
  int p_WE = 0, v_WE = 0;  // where the end effector's position and velocity begin in x, in W
  int effector_v = 0;      // and where its velocity begins in v
  std::vector<ModelContact> contacts;  // all that the model can have
  // the bodies' names and shapes, the end effector's radius and the table; not where they are
  scene::Scene world;

  int n_c() const noexcept { return static_cast<int>(contacts.size()); }
  /// Names of the blocks that carry weights, each once, in their order.
  std::vector<std::string> weights() const;
  /// Whose block carries this name: of each body once, in their order.
  std::vector<int> bodies(const std::string& weight) const;
};

/// Simplified dynamics with contacts, of a scene's end effector and bodies [C3, section VII].
class PlanningModel {
 public:
  explicit PlanningModel(Layout layout) : layout_(std::move(layout)) {}
  virtual ~PlanningModel() = default;

  const Layout& layout() const noexcept { return layout_; }

  /// The state of the scene's end effector and bodies.
  /// @param x (n_x) is overwritten
  virtual void state(const scene::Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const = 0;
  /// The state of a scene in the coordinates of the model about another one, where the model has
  /// coordinates of its own for each: a rotation from the orientation there.
  virtual void state_about(const scene::Scene& scene, const scene::Scene& /*about*/,
                           Eigen::Ref<Eigen::VectorXd> x) const {
    state(scene, x);
  }

  /// Which body of the scene the layout's body i is: of a model that has not all of them it
  /// changes from scene to scene.
  virtual int body(int i, const scene::Scene& /*about*/) const noexcept { return i; }

  /// The multi-contact model at this scene.
  /// @param contacts indices into layout().contacts, in the order of λ
  ContactSystem contact_system(const scene::Scene& scene, const std::vector<int>& contacts) const {
    ContactSystem system;
    evaluate(scene, contacts, system);
    return system;
  }
  /// The same in place of another one.
  virtual void evaluate(const scene::Scene& scene, const std::vector<int>& contacts,
                        ContactSystem& system) const = 0;

 private:
  Layout layout_;
};

/// All contacts of a model, in their order.
std::vector<int> all_contacts(const Layout& layout);

/// What the contacts exert on the end effector, in W [N]: J_Eᵀ λ with the rows of `system`.
/// @param lambda of the Stewart–Trinkle system of `system`, unscaled [N]
Eigen::Vector3d force_on_end_effector(const Layout& layout, const ContactSystem& system,
                                      const Eigen::Ref<const Eigen::VectorXd>& lambda);

}  // namespace c3rt::model
