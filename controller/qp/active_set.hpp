#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "controller/qp/qp_rows.hpp"

namespace c3rt::qp {

/// A guess of which rows of a QP are active, and how a solution with these rows as equalities and
/// the others left out corrects it [primal-dual active set]. After `prepare` nothing allocates.
class ActiveSet {
 public:
  enum class Bound : char { kNone, kLower, kUpper, kEquality };

  /// How many rows a solution showed to be guessed wrongly.
  struct Corrections {
    int violated = 0;    // left out, but outside their bounds
    int wrong_sign = 0;  // active, but with a multiplier that pushes outwards
    int all() const noexcept { return violated + wrong_sign; }
  };

  /// How far a value may be beyond its bound.
  static double slack(double value) noexcept {
    return kTolerance * std::max(std::abs(value), 1e-3);
  }

  /// The rows must outlive the calls of everything below.
  explicit ActiveSet(const QpRows& rows) : rows_(rows) {}

  /// For all of the rows. May allocate.
  void prepare();
  /// Only what has l = u is active. RT.
  void deactivate_all() noexcept;

  Bound operator[](int row) const noexcept { return bound_[row]; }
  void set(int row, Bound bound) noexcept { bound_[row] = bound; }
  /// The bound of an active row.
  double target(int row) const noexcept {
    return bound_[row] == Bound::kUpper ? rows_[row].upper : rows_[row].lower;
  }

  /// Deactivates rows whose multiplier has the wrong sign and activates violated ones. RT.
  /// @param value       aᵀ z of each row
  /// @param multiplier  of each row; positive pushes up
  /// @param inverse_hessian  of each row, positive: the units in which multipliers compare
  Corrections correct(const Eigen::VectorXd& value, const Eigen::VectorXd& multiplier,
                      const Eigen::VectorXd& inverse_hessian) noexcept;

 private:
  static constexpr double kTolerance = 1e-10;  // of bounds and of signs of multipliers

  bool is(const std::vector<Bound>& rows, int row, Bound kind) const noexcept;
  void activate_run(int first, const Eigen::VectorXd& value) noexcept;

  const QpRows& rows_;
  std::vector<Bound> bound_;
  std::vector<Bound> violated_;  // per row: the side
};

}  // namespace c3rt::qp
