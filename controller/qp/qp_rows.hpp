#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "controller/qp/problem.hpp"

namespace c3rt::qp {

/// The constraints of the QP step as a list of rows l ≤ aᵀ z_k ≤ u, or of x_N (stage N), each with
/// a finite side; a has one entry 1, or the largest entry ±1. After `set` nothing allocates.
class QpRows {
 public:
  struct Row {
    int stage;
    int coordinate;  // of the entry 1; −1: a is column `normal` of the normals
    int normal;
    double lower, upper;
  };

  explicit QpRows(const Sizes& sizes) : sizes_(sizes) {}

  /// Constraints that passed `check`. May allocate.
  void set(const Constraints& constraints);
  /// With a fixed λ_0 its bounds are no rows. RT.
  void fix_lambda_0(bool fixed) noexcept { count_ = fixed ? first_of_lambda_0_ : all(); }

  int all() const noexcept { return static_cast<int>(rows_.size()); }
  int count() const noexcept { return count_; }
  const Row& operator[](int i) const noexcept { return rows_[i]; }

  /// The row of the same entry of z one stage later (step 1) or earlier (−1), or −1. RT.
  int neighbor(int i, int step) const noexcept { return step > 0 ? later_[i] : earlier_[i]; }

  /// How far a value is above its upper bound, or, negative, below its lower; 0 between them. RT.
  double outside(int i, double value) const noexcept {
    const Row& row = rows_[i];
    return value > row.upper ? value - row.upper : std::min(value - row.lower, 0.0);
  }

  /// aᵀ z_k, or aᵀ x_N. RT.
  double value(int i, const Eigen::MatrixXd& z, const Eigen::VectorXd& x_N) const noexcept;
  /// Its largest term |a_j z_j|. RT.
  double largest_term(int i, const Eigen::MatrixXd& z, const Eigen::VectorXd& x_N) const noexcept;
  /// Adds c a to what belongs to stage k or x_N. RT.
  void add(int i, double c, Eigen::MatrixXd& gradient, Eigen::VectorXd& gradient_N) const noexcept;
  /// The a of a row without a coordinate (n_z); nullptr for one with. RT.
  const double* normal(int i) const noexcept {
    return rows_[i].coordinate >= 0 ? nullptr : normals_[rows_[i].normal].data();
  }

 private:
  void add_bounds(int k, int first, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);
  void find_neighbours();
  void add_general(int k, const Eigen::VectorXd& a, double lower, double upper);

  Sizes sizes_;
  std::vector<Row> rows_;
  std::vector<int> later_, earlier_;
  std::vector<Eigen::VectorXd> normals_;
  int first_of_lambda_0_ = 0, count_ = 0;
};

}  // namespace c3rt::qp
