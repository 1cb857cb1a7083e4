#include "controller/c3/problem.hpp"

#include <cmath>
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

void require_bounds(const std::string& lower_name, const Eigen::VectorXd& lower,
                    const std::string& upper_name, const Eigen::VectorXd& upper,
                    Eigen::Index size) {
  for (const auto& [name, bound] : {std::pair{lower_name, &lower}, std::pair{upper_name, &upper}}) {
    if (bound->size() != 0 && bound->size() != size) {
      refuse(name, std::to_string(size) + " values or none", std::to_string(bound->size()));
    }
    if (bound->hasNaN()) refuse(name, "numbers or infinity", "NaN");
  }
  if (lower.size() == 0 || upper.size() == 0) return;
  for (Eigen::Index i = 0; i < size; ++i) {
    if (lower[i] > upper[i]) {
      refuse(lower_name + "[" + std::to_string(i) + "]",
             "at most " + upper_name + " = " + text(upper[i]), text(lower[i]));
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
  at_least("Sizes.n_lambda", sizes.n_lambda, 1);
  at_least("Sizes.n_u", sizes.n_u, 1);
  at_least("Sizes.N", sizes.N, 1);
}

void check(const Costs& costs, const Sizes& sizes) {
  require_weight("Costs.Q", costs.Q, sizes.n_x);
  require_weight("Costs.Q_N", costs.Q_N, sizes.n_x);
  require_weight("Costs.R", costs.R, sizes.n_u);
  require_weight("Costs.G", costs.G, sizes.n_z());
  require_weight("Costs.U", costs.U, sizes.n_z());
  // without this the QP step has no unique minimiser
  const int n_nu = sizes.n_lambda + sizes.n_u;
  Eigen::MatrixXd input_weight = costs.G.bottomRightCorner(n_nu, n_nu);
  input_weight.bottomRightCorner(sizes.n_u, sizes.n_u) += costs.R;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(input_weight, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] > 0.0)) {
    refuse("Costs.G", "a positive definite weight of lambda and, together with R, of u",
           "the eigenvalue " + text(eigen.eigenvalues()[0]));
  }
}

void check(const Bounds& bounds, const Sizes& sizes) {
  require_bounds("Bounds.x_min", bounds.x_min, "Bounds.x_max", bounds.x_max, sizes.n_x);
  require_bounds("Bounds.lambda_min", bounds.lambda_min, "Bounds.lambda_max", bounds.lambda_max,
                 sizes.n_lambda);
  require_bounds("Bounds.u_min", bounds.u_min, "Bounds.u_max", bounds.u_max, sizes.n_u);
}

}  // namespace c3rt::c3
