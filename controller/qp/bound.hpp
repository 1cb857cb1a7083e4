#pragma once
#include <limits>

#include <Eigen/Core>

namespace c3rt::qp {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Entry i of a bound; an empty bound is none.
inline double bound_at(const Eigen::VectorXd& bound, Eigen::Index i, double none) noexcept {
  return bound.size() == 0 ? none : bound[i];
}

}  // namespace c3rt::qp
