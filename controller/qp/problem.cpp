#include "controller/qp/problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "controller/qp/requirements.hpp"

namespace c3rt::qp {
namespace {

void require_bound(const std::string& name, const Eigen::VectorXd& bound, Eigen::Index size) {
  if (bound.size() != 0 && bound.size() != size) {
    refuse(name, std::to_string(size) + " values or none", std::to_string(bound.size()));
  }
  if (bound.hasNaN()) refuse(name, "numbers or infinity", "NaN");
}

void require_order(const std::string& lower_name, const Eigen::VectorXd& lower,
                   const std::string& upper_name, const Eigen::VectorXd& upper) {
  if (lower.size() == 0 || upper.size() == 0) return;
  for (Eigen::Index i = 0; i < lower.size(); ++i) {
    if (lower[i] > upper[i]) {
      refuse(lower_name + "[" + std::to_string(i) + "]",
             "at most " + upper_name + " = " + text(upper[i]), text(lower[i]));
    }
  }
}

void require_bounds(const std::string& field, const PerStage<Eigen::VectorXd>& lower,
                    const PerStage<Eigen::VectorXd>& upper, Eigen::Index size, const Sizes& sizes) {
  const std::string lower_field = field + "_min", upper_field = field + "_max";
  require_count(lower_field, lower, sizes);
  require_count(upper_field, upper, sizes);
  for (int k = 0; k < std::max(lower.count(), upper.count()); ++k) {
    const std::string lower_name = name_of(lower_field, lower, k);
    const std::string upper_name = name_of(upper_field, upper, k);
    require_bound(lower_name, lower[k], size);
    require_bound(upper_name, upper[k], size);
    require_order(lower_name, lower[k], upper_name, upper[k]);
  }
}

bool has_bound(const Eigen::VectorXd& bound) {
  return (bound.array().abs() < std::numeric_limits<double>::infinity()).any();
}

bool has_bound(const PerStage<Eigen::VectorXd>& bounds) {
  for (int k = 0; k < bounds.count(); ++k) {
    if (has_bound(bounds[k])) return true;
  }
  return false;
}

}  // namespace

void check(const Sizes& sizes) {
  const auto at_least = [](const char* name, int value, int smallest) {
    if (value < smallest) {
      refuse(name, std::to_string(smallest) + " or more", std::to_string(value));
    }
  };
  at_least("Sizes.n_x", sizes.n_x, 1);
  at_least("Sizes.n_lambda", sizes.n_lambda, 0);
  at_least("Sizes.n_u", sizes.n_u, 0);
  at_least("Sizes.N", sizes.N, 1);
}

void check(const Costs& costs, const Sizes& sizes) {
  require_weights("Costs.Q", costs.Q, sizes.n_x, sizes);
  require_weight("Costs.Q_N", costs.Q_N, sizes.n_x);
  require_weights("Costs.R", costs.R, sizes.n_u, sizes);
}

void check(const Constraints& constraints, const Sizes& sizes) {
  require_bounds("Constraints.x", constraints.x_min, constraints.x_max, sizes.n_x, sizes);
  require_bounds("Constraints.lambda", constraints.lambda_min, constraints.lambda_max,
                 sizes.n_lambda, sizes);
  require_bounds("Constraints.u", constraints.u_min, constraints.u_max, sizes.n_u, sizes);
  require_bound("Constraints.x_N_min", constraints.x_N_min, sizes.n_x);
  require_bound("Constraints.x_N_max", constraints.x_N_max, sizes.n_x);
  require_order("Constraints.x_N_min", constraints.x_N_min, "Constraints.x_N_max",
                constraints.x_N_max);
  require_count("Constraints.C", constraints.C, sizes);
  for (int k = 0; k < constraints.C.count(); ++k) {
    const Eigen::MatrixXd& C = constraints.C[k];
    if (C.size() == 0) continue;
    const std::string name = name_of("Constraints.C", constraints.C, k);
    if (C.cols() != sizes.n_z()) {
      refuse(name, std::to_string(sizes.n_z()) + " columns", std::to_string(C.cols()));
    }
    if (!C.allFinite()) refuse(name, "finite numbers", "NaN or infinity");
  }
  require_count("Constraints.C_min", constraints.C_min, sizes);
  require_count("Constraints.C_max", constraints.C_max, sizes);
  for (int k = 0; k < sizes.N; ++k) {
    const Eigen::Index rows = constraints.C[k].rows();
    const std::string lower = name_of("Constraints.C_min", constraints.C_min, k);
    const std::string upper = name_of("Constraints.C_max", constraints.C_max, k);
    require_bound(lower, constraints.C_min[k], rows);
    require_bound(upper, constraints.C_max[k], rows);
    require_order(lower, constraints.C_min[k], upper, constraints.C_max[k]);
  }
}

bool any(const Constraints& constraints) {
  return has_bound(constraints.x_min) || has_bound(constraints.x_max) ||
         has_bound(constraints.lambda_min) || has_bound(constraints.lambda_max) ||
         has_bound(constraints.u_min) || has_bound(constraints.u_max) ||
         has_bound(constraints.x_N_min) || has_bound(constraints.x_N_max) ||
         has_bound(constraints.C_min) || has_bound(constraints.C_max);
}

double cost(const Costs& costs, const Sizes& sizes,
            const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
            const Eigen::Ref<const Eigen::MatrixXd>& z,
            const Eigen::Ref<const Eigen::VectorXd>& x_N) {
  Eigen::VectorXd e = x_N - x_desired.col(sizes.N);
  double sum = e.dot(costs.Q_N * e);
  for (int k = 0; k < sizes.N; ++k) {
    const auto z_k = z.col(k);
    e = sizes.x(z_k) - x_desired.col(k);
    const Eigen::VectorXd u = sizes.u(z_k);
    sum += e.dot(costs.Q[k] * e) + u.dot(costs.R[k] * u);
  }
  return sum;
}

}  // namespace c3rt::qp
