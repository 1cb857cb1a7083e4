#pragma once
// Any mechanism with motors, and free bodies among it, with the contacts that are chosen by name.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/model/contact_model.hpp"
#include "controller/model/registry.hpp"
#include "controller/model/system_model.hpp"
#include "controller/scene/mechanism.hpp"

namespace c3rt::model {

struct MechanismParameters {
  std::shared_ptr<scene::Mechanism> mechanism;  // of this model alone
  std::vector<Between> contacts;                // at least one
  ContactModel contact_model = ContactModel::kAnitescu;
  int directions = 2;      // of friction at each contact, 0 to 8: two edges of the cone for each
  int support_points = 4;  // of a body with a plane, 3 or 4
  // the first direction of friction is across this and the normal: of a mechanism that moves in a
  // plane, that plane's normal, and one direction is enough; none: as `tangents`, which suits
  // motion over a table
  std::optional<Eigen::Vector3d> across = {};
};

/// x = [q; v] of scene/mechanism.hpp: what MuJoCo's joints have, and of each free body its centre
/// of mass and its rotation vector from home; u = the motors' inputs. Contacts are between convex
/// geoms, where they are nearest, and of a body with a plane at its support points, those of the
/// face that looks at the plane the most, with edges that are turned from point to point as in
/// `make_objects_model`. What a motor moves touches a body that none moves where they overlap
/// (`no_overlap`). Where `closest` chooses, the chosen ones keep their order.
///
/// It serves one thread at a time.
class MechanismModel final : public SystemModel {
 public:
  /// A contact where the model was evaluated last.
  struct Contact {
    int first, second;  // rigid bodies of the mechanism, 0: the world; the normal points to first
    int first_surface, second_surface;  // −1: all those of a body on a plane that were chosen
    double distance;                    // between the surfaces, negative where they overlap [m]
    Eigen::Vector3d normal, t, s;       // in W
    Eigen::Vector3d p_first, p_second;  // on the surfaces, in W [m]
    double mu;
  };

  /// @throws std::invalid_argument naming what there is no body or geom of, and those that there
  /// are; for two that cannot touch; for numbers out of range
  explicit MechanismModel(const MechanismParameters& parameters);
  ~MechanismModel() override;

  const scene::Mechanism& mechanism() const noexcept { return *parameters_.mechanism; }
  ContactModel contact_model() const noexcept { return parameters_.contact_model; }
  int n_c() const noexcept { return static_cast<int>(found_.size()); }
  int n_e() const noexcept { return 2 * parameters_.directions; }

  /// The multi-contact model at x. No heap where `system` had these sizes.
  void evaluate(const Eigen::Ref<const Eigen::VectorXd>& x, ContactSystem& system) const;
  /// Of the last evaluation, in the order of λ.
  const std::vector<Contact>& contacts() const noexcept { return found_; }

  lcs::Lcs planning_system(const Eigen::VectorXd& x, double dt) const override;
  /// Within the motors' ranges.
  void clip(Eigen::Ref<Eigen::VectorXd> u) const override;

 private:
  struct Candidate;
  struct Group;
  struct Plan;
  MechanismModel(const MechanismParameters& parameters, Plan plan);
  static Plan plan(const MechanismParameters& parameters);
  void measure(const Candidate& candidate, Contact& contact) const;
  void choose(const Group& group, std::size_t& count) const;
  scene::Place place_of(int surface) const noexcept;

  MechanismParameters parameters_;
  std::vector<Candidate> candidates_;
  std::vector<Group> groups_;
  // what is computed, in storage of its own
  mutable scene::SmoothMotion motion_;
  mutable std::vector<scene::Place> places_;
  mutable std::vector<Contact> measured_, found_;
  mutable std::vector<int> order_;
  mutable Eigen::MatrixXd J_first_, J_second_;
};
SystemKind mechanism_kind();

}  // namespace c3rt::model
