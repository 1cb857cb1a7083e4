#pragma once
// What Algorithm 1 weighs, by the names of the model's blocks.
#include <map>
#include <string>
#include <vector>

#include "controller/c3/problem.hpp"
#include "controller/model/contact_model.hpp"
#include "controller/model/planning_model.hpp"

namespace c3rt::planner {

constexpr double kLargestWeight = 1e12;  // that a scenario or a client may give

/// Diagonal weights of one phase. G and U act on the scaled forces (docs/math.md).
struct PhaseWeights {
  // by block of x: one for all bodies, or that of the active body and those of the others
  std::map<std::string, std::vector<double>> Q;
  double R;
  double G_x, G_u;
  std::map<std::string, double> G_lambda;  // by the names of lambda_weights()
  double U_x, U_lambda, U_u;
  /// By row of a gap: of the friction cone, of the distance, of the slip. Any other weight is the
  /// first.
  struct Rows {
    double cone, distance, slip;
  };
  // by the keys of a projection and of a weight that it alone has. Those of x and u are U_x and
  // U_u; one of forces in the consensus term that is not here is G's, contact by contact
  std::map<std::string, std::map<std::string, Rows>> of_projections;
  // those that count contact by contact, by the contact's name in lambda_weights(); 1 without
  std::map<std::string, std::map<std::string, std::map<std::string, double>>> of_contacts;
};

/// The names of λ's weights for all contacts of a model: "gamma", then "…_normal" and
/// "…_tangential" of each kind of contact.
std::vector<std::string> lambda_weights(const model::Layout& layout);
/// The names of the kinds of contact alone.
std::vector<std::string> contact_weights(const model::Layout& layout);

/// The planning problem of a scenario: a model with the contacts that it plans with.
struct PlanningProblem {
  const model::Layout* layout;
  std::vector<int> contacts;  // of the layout, in the order of λ
  model::ContactModel contact_model;

  model::LambdaLayout lambda() const noexcept {
    return {contact_model, static_cast<int>(contacts.size()), layout->n_e};
  }
};

/// The costs of Algorithm 1 in one phase.
/// @param active the body that is worked on: it and the first one change their weights
/// @throws std::out_of_range if a block or a contact has no weight (named)
c3::Costs costs_of(const PlanningProblem& problem, const PhaseWeights& weights, int active = 0);

}  // namespace c3rt::planner
