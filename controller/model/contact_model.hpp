#pragma once
// The contact models by name, and the order of their λ: nobody else counts forces.
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/model/contact_system.hpp"

namespace c3rt::model {

enum class ContactModel {
  kStewartTrinkle,  // [C3, eq. (8), (9)]; λ are forces [N]
  kAnitescu,        // [C3, eq. (12), (13)]; F positive semidefinite, as the convex projection needs
                    // it; λ are impulses [N s]
};

/// What a row of complementarity η = E x + F λ + H u + c measures.
enum class Row { kCone, kDistance, kSlip };

/// Where the λ of n_c contacts with n_e edges each stand.
class LambdaLayout {
 public:
  LambdaLayout(ContactModel model, int n_c, int n_e) noexcept
      : model_(model), n_c_(n_c), n_e_(n_e) {}

  int size() const noexcept;
  /// Whether each contact has a slack γ of its friction cone and a normal force of its own; else
  /// the edges are all there is.
  bool has_normal() const noexcept { return model_ == ContactModel::kStewartTrinkle; }
  int gamma(int contact) const noexcept { return contact; }
  int normal(int contact) const noexcept { return n_c_ + contact; }
  /// The first of a contact's edges +t −t +s −s.
  int edges(int contact) const noexcept;
  int edge_count() const noexcept;  // of each contact
  /// Anitescu's rows, distance and slip in one, count as those of the cone.
  Row row(int i) const noexcept;

 private:
  ContactModel model_;
  int n_c_, n_e_;
};

/// The system's LCS.
/// @param dt time step Δt [s]
lcs::Lcs to_lcs(ContactModel model, const ContactSystem& system, double dt);
/// The same in place of another one, without heap where that had the same sizes.
void to_lcs(ContactModel model, const ContactSystem& system, double dt, LcsStorage& storage,
            lcs::Lcs& lcs);

/// What a λ of this model is to be multiplied with for newtons, where its forces were scaled.
/// @param scale of the forces, 1: none  @param dt of its LCS [s]
double newtons(ContactModel model, double scale, double dt) noexcept;

}  // namespace c3rt::model
