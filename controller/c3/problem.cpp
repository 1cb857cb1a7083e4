#include "controller/c3/problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include <Eigen/Eigenvalues>

namespace c3rt::c3 {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& expected,
                         const std::string& got) {
  throw std::invalid_argument(name + ": expected " + expected + ", got " + got);
}

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::string shape(Eigen::Index rows, Eigen::Index cols) {
  return std::to_string(rows) + " x " + std::to_string(cols);
}

/// Eigenvalues this far below zero, beside the largest entry, are still rounding.
constexpr double kRounding = 1e-12;

void require_weight(const std::string& name, const Eigen::MatrixXd& weight, Eigen::Index size) {
  if (weight.rows() != size || weight.cols() != size) {
    refuse(name, shape(size, size), shape(weight.rows(), weight.cols()));
  }
  if (!weight.allFinite()) refuse(name, "finite numbers", "NaN or infinity");
  const double largest = size > 0 ? weight.cwiseAbs().maxCoeff() : 0.0;
  if (!(weight - weight.transpose()).isZero(kRounding * largest)) {
    refuse(name, "a symmetric matrix",
           "an asymmetry of " + text((weight - weight.transpose()).cwiseAbs().maxCoeff()));
  }
  if (weight.isDiagonal(0.0)) {
    if (size > 0 && weight.diagonal().minCoeff() < 0.0) {
      refuse(name, "a positive semidefinite matrix",
             "the eigenvalue " + text(weight.diagonal().minCoeff()));
    }
    return;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(weight, Eigen::EigenvaluesOnly);
  const double smallest = eigen.eigenvalues()[0];
  if (!(smallest >= -kRounding * static_cast<double>(size) * largest)) {
    refuse(name, "a positive semidefinite matrix", "the eigenvalue " + text(smallest));
  }
}

/// "Costs.Q" where one stands for all stages, "Costs.Q[3]" where each has its own.
template <typename T>
std::string name_of(const std::string& field, const PerStage<T>& all, int k) {
  return all.count() == 1 ? field : field + "[" + std::to_string(k) + "]";
}

template <typename T>
void require_count(const std::string& field, const PerStage<T>& all, const Sizes& sizes) {
  if (all.count() != 1 && all.count() != sizes.N) {
    refuse(field, "one for all stages or N = " + std::to_string(sizes.N),
           std::to_string(all.count()));
  }
}

void require_weights(const std::string& field, const PerStage<Eigen::MatrixXd>& all,
                     Eigen::Index size, const Sizes& sizes) {
  require_count(field, all, sizes);
  for (int k = 0; k < all.count(); ++k) require_weight(name_of(field, all, k), all[k], size);
}

void require_definite(const std::string& name, const Eigen::MatrixXd& weight, Eigen::Index size) {
  require_weight(name, weight, size);
  if (size == 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(weight, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] > 0.0)) {
    refuse(name, "a positive definite matrix", "the eigenvalue " + text(eigen.eigenvalues()[0]));
  }
}

void require_vector(const std::string& name, const Eigen::VectorXd& weight, Eigen::Index size,
                    bool zero_allowed) {
  if (weight.size() != size) {
    refuse(name, std::to_string(size) + " values", std::to_string(weight.size()));
  }
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!std::isfinite(weight[i]) || weight[i] < 0.0 || (weight[i] == 0.0 && !zero_allowed)) {
      refuse(name + "[" + std::to_string(i) + "]",
             zero_allowed ? "a number of 0 or more" : "a positive number", text(weight[i]));
    }
  }
}

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

/// Without this the QP step has no unique minimiser.
void require_definite_inputs(const Costs& costs, const Sizes& sizes) {
  const int n_nu = sizes.n_lambda + sizes.n_u;
  if (n_nu == 0) return;
  for (int k = 0; k < std::max(costs.G.count(), costs.R.count()); ++k) {
    Eigen::MatrixXd weight = costs.G[k].bottomRightCorner(n_nu, n_nu);
    weight.bottomRightCorner(sizes.n_u, sizes.n_u) += costs.R[k];
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(weight, Eigen::EigenvaluesOnly);
    if (!(eigen.eigenvalues()[0] > 0.0)) {
      refuse(name_of("Costs.G", costs.G, k),
             "a positive definite weight of lambda and, together with R, of u",
             "the eigenvalue " + text(eigen.eigenvalues()[0]));
    }
  }
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

void check(const Costs& costs, const Sizes& sizes, ProjectionKind projection) {
  require_weights("Costs.Q", costs.Q, sizes.n_x, sizes);
  require_weight("Costs.Q_N", costs.Q_N, sizes.n_x);
  require_weights("Costs.R", costs.R, sizes.n_u, sizes);
  const bool needs_U = projection == ProjectionKind::kMiqp || projection == ProjectionKind::kAdmm;
  if (needs_U || costs.U.size() != 0) require_weight("Costs.U", costs.U, sizes.n_z());
  if (projection == ProjectionKind::kConvex) {
    require_definite("Costs.convex.Q_x", costs.convex.Q_x, sizes.n_x);
    require_definite("Costs.convex.Q_u", costs.convex.Q_u, sizes.n_u);
    if (!(costs.convex.alpha >= 0.0 && costs.convex.alpha <= 1.0)) {
      refuse("Costs.convex.alpha", "a number from 0 to 1", text(costs.convex.alpha));
    }
    if (!(costs.convex.epsilon >= 0.0 && std::isfinite(costs.convex.epsilon))) {
      refuse("Costs.convex.epsilon", "a number of 0 or more", text(costs.convex.epsilon));
    }
  }
  if (projection == ProjectionKind::kPlus) {
    require_vector("Costs.plus.g_lambda", costs.plus.g_lambda, sizes.n_lambda, true);
    require_vector("Costs.plus.g_eta", costs.plus.g_eta, sizes.n_lambda, true);
    require_vector("Costs.plus.u_lambda", costs.plus.u_lambda, sizes.n_lambda, false);
    require_vector("Costs.plus.u_eta", costs.plus.u_eta, sizes.n_lambda, false);
    return;
  }
  require_weights("Costs.G", costs.G, sizes.n_z(), sizes);
  require_definite_inputs(costs, sizes);
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

}  // namespace c3rt::c3
