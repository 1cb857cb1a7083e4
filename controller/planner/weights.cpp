#include "controller/planner/weights.hpp"

#include <algorithm>
#include <stdexcept>

namespace c3rt::planner {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

template <typename Value>
const Value& named(const std::map<std::string, Value>& weights, const std::string& name) {
  const auto found = weights.find(name);
  if (found == weights.end())
    throw std::out_of_range("weights: expected one of " + name + ", got none");
  return found->second;
}

VectorXd Q_of_x(const model::Layout& layout, const PhaseWeights& weights, int active) {
  VectorXd Q = VectorXd::Zero(layout.n_x);
  for (const model::StateBlock& block : layout.x) {
    if (block.name.empty()) continue;
    const std::vector<double>& of_bodies = named(weights.Q, block.name);
    // the active body has the first, the first body that of the active one
    const int turn = block.body == active ? 0 : block.body == 0 ? active : block.body;
    const bool alike = of_bodies.size() == 1;
    Q.segment(block.start, block.size)
        .setConstant(of_bodies.at(alike ? 0 : static_cast<std::size_t>(turn)));
  }
  return Q;
}

VectorXd G_of_lambda(const PlanningProblem& problem, const PhaseWeights& weights) {
  const model::LambdaLayout lambda = problem.lambda();
  VectorXd G(lambda.size());
  for (int i = 0; i < static_cast<int>(problem.contacts.size()); ++i) {
    const int contact = problem.contacts[static_cast<std::size_t>(i)];
    const std::string& kind = problem.layout->contacts[static_cast<std::size_t>(contact)].weight;
    if (lambda.has_normal()) {
      G[lambda.gamma(i)] = named(weights.G_lambda, "gamma");
      G[lambda.normal(i)] = named(weights.G_lambda, kind + "_normal");
    }
    G.segment(lambda.edges(i), lambda.edge_count())
        .setConstant(named(weights.G_lambda, kind + "_tangential"));
  }
  return G;
}

VectorXd of_rows(const PhaseWeights::Rows& rows, const model::LambdaLayout& lambda) {
  VectorXd result(lambda.size());
  for (int i = 0; i < lambda.size(); ++i) {
    const model::Row row = lambda.row(i);
    result[i] = row == model::Row::kCone       ? rows.cone
                : row == model::Row::kDistance ? rows.distance
                                               : rows.slip;
  }
  return result;
}

/// One number for all pairs of a contact.
VectorXd of_contacts(const PlanningProblem& problem, const std::map<std::string, double>& weights) {
  const model::LambdaLayout lambda = problem.lambda();
  VectorXd result = VectorXd::Ones(lambda.size());
  for (int i = 0; i < static_cast<int>(problem.contacts.size()); ++i) {
    const int contact = problem.contacts[static_cast<std::size_t>(i)];
    const auto found =
        weights.find(problem.layout->contacts[static_cast<std::size_t>(contact)].weight);
    if (found == weights.end()) continue;
    if (lambda.has_normal()) {
      result[lambda.gamma(i)] = found->second;
      result[lambda.normal(i)] = found->second;
    }
    result.segment(lambda.edges(i), lambda.edge_count()).setConstant(found->second);
  }
  return result;
}

/// A weight that one projection alone has.
void set(const c3::ProjectionWeight& weight, const PhaseWeights& weights,
         const std::map<std::string, PhaseWeights::Rows>& own, const model::LambdaLayout& lambda,
         const VectorXd& G_lambda, const c3::Sizes& sizes, c3::Costs& costs) {
  using Shape = c3::ProjectionWeight::Shape;
  switch (weight.shape) {
    case Shape::kOfStates:
      weight.fill(costs, sizes, weights.U_x);
      break;
    case Shape::kOfInputs:
      weight.fill(costs, sizes, weights.U_u);
      break;
    case Shape::kOfForces:
      if (weight.of_consensus && own.count(weight.key) == 0) {
        weight.vector(costs) = G_lambda;
        break;
      }
      [[fallthrough]];
    case Shape::kNumber:
      weight.fill(costs, sizes, named(own, weight.key).cone);
      break;
    case Shape::kOfGaps:
      weight.vector(costs) = of_rows(named(own, weight.key), lambda);
      break;
    case Shape::kOfContacts:
      break;  // see of_contacts
  }
}

}  // namespace

std::vector<std::string> contact_weights(const model::Layout& layout) {
  std::vector<std::string> names;
  for (const model::ModelContact& contact : layout.contacts) {
    if (std::find(names.begin(), names.end(), contact.weight) == names.end())
      names.push_back(contact.weight);
  }
  return names;
}

std::vector<std::string> lambda_weights(const model::Layout& layout) {
  std::vector<std::string> names{"gamma"};
  for (const std::string& contact : contact_weights(layout)) {
    names.push_back(contact + "_normal");
    names.push_back(contact + "_tangential");
  }
  return names;
}

c3::Costs costs_of(const PlanningProblem& problem, const PhaseWeights& weights, int active) {
  const int n_x = problem.layout->n_x, n_u = problem.layout->n_u;
  const model::LambdaLayout lambda = problem.lambda();
  const int n_lambda = lambda.size(), n_z = n_x + n_lambda + n_u;
  const VectorXd Q = Q_of_x(*problem.layout, weights, active);
  const VectorXd G_lambda = G_of_lambda(problem, weights);

  VectorXd G(n_z), U(n_z);
  G << VectorXd::Constant(n_x, weights.G_x), G_lambda, VectorXd::Constant(n_u, weights.G_u);
  U << VectorXd::Constant(n_x, weights.U_x), VectorXd::Constant(n_lambda, weights.U_lambda),
      VectorXd::Constant(n_u, weights.U_u);

  c3::Costs costs;
  costs.Q = Q.asDiagonal();
  costs.Q_N = Q.asDiagonal();
  costs.R = weights.R * MatrixXd::Identity(n_u, n_u);
  costs.G = G.asDiagonal();
  if (weights.U_x > 0.0) costs.U = U.asDiagonal();  // else the projection has no use for it
  for (const auto type : c3::kProjectionTypes) {
    const auto own = weights.of_projections.find(type().key);
    if (own == weights.of_projections.end()) continue;
    for (const c3::ProjectionWeight& weight : type().weights)
      set(weight, weights, own->second, lambda, G_lambda, {n_x, n_lambda, n_u, 1}, costs);
    const auto by_contact = weights.of_contacts.find(type().key);
    if (by_contact == weights.of_contacts.end()) continue;
    for (const c3::ProjectionWeight& weight : type().weights) {
      const auto given = by_contact->second.find(weight.key);
      if (given != by_contact->second.end())
        weight.vector(costs) = of_contacts(problem, given->second);
    }
  }
  return costs;
}

}  // namespace c3rt::planner
