#include "controller/qp/requirements.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include <Eigen/Eigenvalues>

namespace c3rt::qp {
namespace {

std::string shape(Eigen::Index rows, Eigen::Index cols) {
  return std::to_string(rows) + " x " + std::to_string(cols);
}

/// Eigenvalues this far below zero, beside the largest entry, are still rounding.
constexpr double kRoundingOfEigenvalues = 1e-12;

}  // namespace

void refuse(const std::string& name, const std::string& expected, const std::string& got) {
  throw std::invalid_argument(name + ": expected " + expected + ", got " + got);
}

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

void require_weight(const std::string& name, const Eigen::MatrixXd& weight, Eigen::Index size) {
  if (weight.rows() != size || weight.cols() != size) {
    refuse(name, shape(size, size), shape(weight.rows(), weight.cols()));
  }
  if (!weight.allFinite()) refuse(name, "finite numbers", "NaN or infinity");
  const double largest = size > 0 ? weight.cwiseAbs().maxCoeff() : 0.0;
  if (!(weight - weight.transpose()).isZero(kRoundingOfEigenvalues * largest)) {
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
  if (!(smallest >= -kRoundingOfEigenvalues * static_cast<double>(size) * largest)) {
    refuse(name, "a positive semidefinite matrix", "the eigenvalue " + text(smallest));
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

}  // namespace c3rt::qp
