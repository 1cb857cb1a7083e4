#include "controller/c3/projection/registry.hpp"

#include "controller/c3/problem.hpp"
#include "controller/c3/projection.hpp"
#include "controller/c3/solver.hpp"

namespace c3rt::c3 {

void ProjectionWeight::fill(Costs& costs, const qp::Sizes& sizes, double value) const {
  switch (shape) {
    case Shape::kOfStates:
      matrix(costs) = value * Eigen::MatrixXd::Identity(sizes.n_x, sizes.n_x);
      break;
    case Shape::kOfInputs:
      matrix(costs) = value * Eigen::MatrixXd::Identity(sizes.n_u, sizes.n_u);
      break;
    case Shape::kOfForces:
    case Shape::kOfGaps:
    case Shape::kOfContacts:
      vector(costs).setConstant(sizes.n_lambda, value);
      break;
    case Shape::kNumber:
      number(costs) = value;
      break;
  }
}

const ProjectionType& projection_type(ProjectionKind kind) noexcept {
  for (const auto type : kProjectionTypes) {
    if (type().kind == kind) return type();
  }
  return kProjectionTypes.front()();
}

std::unique_ptr<Projection> make_projection(const qp::Sizes& sizes, const Settings& settings) {
  const ProjectionType& type = projection_type(settings.projection);
  if (type.check_settings != nullptr) type.check_settings(settings);
  return type.make(sizes, settings);
}

}  // namespace c3rt::c3
