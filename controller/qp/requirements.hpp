#pragma once

#include <string>

#include <Eigen/Core>

#include "controller/qp/problem.hpp"

/// What the checks of problems are made of. Each throws std::invalid_argument with the field's
/// name, what was expected and what came.
namespace c3rt::qp {

[[noreturn]] void refuse(const std::string& name, const std::string& expected,
                         const std::string& got);

std::string text(double value);

/// Symmetric, finite and positive semidefinite.
void require_weight(const std::string& name, const Eigen::MatrixXd& weight, Eigen::Index size);
/// The same and positive definite.
void require_definite(const std::string& name, const Eigen::MatrixXd& weight, Eigen::Index size);
/// One for all stages or N, each as `require_weight`.
void require_weights(const std::string& field, const PerStage<Eigen::MatrixXd>& all,
                     Eigen::Index size, const Sizes& sizes);
/// `size` positive numbers, or non-negative ones.
void require_vector(const std::string& name, const Eigen::VectorXd& weight, Eigen::Index size,
                    bool zero_allowed);

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

}  // namespace c3rt::qp
