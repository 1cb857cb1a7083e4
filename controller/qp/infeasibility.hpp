#pragma once

#include <Eigen/Core>

#include "controller/qp/qp_model.hpp"

namespace c3rt::qp {

/// Whether the rows of a QP step can be met at all. After `prepare` nothing allocates.
class Infeasibility {
 public:
  /// For a model whose costs are set. May allocate.
  void prepare(const QpModel& model);

  /// Whether these multipliers prove that nothing satisfies dynamics and rows [Farkas]: their force
  /// on every input and state cancels, while the rows that they belong to are violated at the
  /// model's point. Positive multipliers belong to lower bounds, negative ones to upper. RT.
  static bool is_proven(QpModel& model, const Eigen::VectorXd& multiplier) noexcept;

  /// Looks for a point that meets all rows, or for multipliers that prove that there is none: true
  /// in the latter case. False may also mean that neither was found. Moves the model's point. RT.
  /// @param inverse_hessian  of each row, see QpModel::measure
  bool prove(QpModel& model, const Eigen::VectorXd& inverse_hessian) noexcept;

  /// Newton steps of the last `prove`.
  int steps() const noexcept { return steps_; }

 private:
  int steps_ = 0;
  Eigen::VectorXd weight_, extra_, multiplier_;  // of the rows
  Eigen::MatrixXd z_;                            // before a step
  Eigen::VectorXd x_N_;
};

}  // namespace c3rt::qp
