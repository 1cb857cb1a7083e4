#pragma once

#include <Eigen/Core>

#include "controller/c3/problem.hpp"

namespace c3rt::test {

/// Costs of which a projection in the norm of U needs nothing else.
inline c3::Costs weighted_by(const Eigen::MatrixXd& U) {
  c3::Costs costs;
  costs.U = U;
  return costs;
}

}  // namespace c3rt::test
