#pragma once

#include <vector>

#include <Eigen/Core>

#include "controller/qp/problem.hpp"
#include "controller/qp/qp_cost.hpp"
#include "controller/qp/qp_rows.hpp"
#include "controller/qp/riccati.hpp"

namespace c3rt::qp {

/// The QP step with its rows, at a point: what methods for constrained problems have in common. Its
/// steps take out what the point misses the dynamics by. Vectors over rows have `rows().all()`
/// entries, of which the first `rows().count()` mean something. After `set_costs` nothing
/// allocates.
class QpModel {
 public:
  explicit QpModel(const Sizes& sizes);

  void set_costs(const Costs& costs, const Constraints& constraints);
  /// As QpStep::start. RT.
  void start(Horizon lcs, StageMatrices W, const Eigen::VectorXd* lambda_0) noexcept;
  /// Takes a new problem and goes to rest, ν = 0 and x_1 … x_N = 0. RT.
  void set_linear_term(double rho, const Eigen::Ref<const Eigen::VectorXd>& x0,
                       const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                       const Eigen::Ref<const Eigen::MatrixXd>& g) noexcept;

  const Sizes& sizes() const noexcept { return sizes_; }
  const QpRows& rows() const noexcept { return rows_; }
  const Eigen::MatrixXd& z() const noexcept { return z_; }
  const Eigen::VectorXd& x_N() const noexcept { return x_N_; }
  /// aᵀ z of every row, at this point and at rest.
  const Eigen::VectorXd& value() const noexcept { return value_; }
  const Eigen::VectorXd& value_at_rest() const noexcept { return value_rest_; }
  /// Its change by the step of the last `newton`.
  double change(int row) const noexcept { return rows_.value(row, step_, step_N_); }

  /// Factors H + Σ w a aᵀ. RT.
  [[nodiscard]] bool factor(const Eigen::VectorXd& weight) noexcept;
  /// Fills `inverse_hessian` of the rows (see Riccati::inverse_hessian_along), never zero. RT.
  void measure(Eigen::VectorXd& inverse_hessian) noexcept;
  /// Keeps the gradient H z − h − Σ m a and the defects of this point. RT.
  void differentiate(const Eigen::VectorXd& multiplier) noexcept;
  /// What stationarity and the dynamics are missed by, each beside its terms; infinity where
  /// rounding leaves λ and u no digits. RT.
  double stationarity(const Eigen::VectorXd& multiplier) noexcept;
  double inconsistency() noexcept;
  /// How far outside its bounds a row is at most, beside its bound and the entries of its kind. RT.
  double violation() const noexcept;
  /// The stationarity of −Σ m a alone, with the last factorisation; no gradient is kept. RT.
  Riccati::Stationarity stationarity_of_multipliers(const Eigen::VectorXd& multiplier) noexcept;
  /// The step of the factored model with the gradient kept plus Σ e a. RT.
  void newton(const Eigen::VectorXd& extra) noexcept;
  /// The same with Σ e a as the only gradient. RT.
  void newton_of_rows(const Eigen::VectorXd& extra) noexcept;
  /// The same from rest, and goes there: the minimiser in one step, without the refinement that
  /// `differentiate`, `newton` and `move` bring. RT.
  void newton_from_rest(const Eigen::VectorXd& extra) noexcept;
  /// Goes α of the step. RT.
  void move(double alpha) noexcept;
  /// The last step beside the point: the largest ratio of the largest entries of x, λ and u. RT.
  double relative_step() noexcept;
  /// To a point of before. RT.
  void go_to(const Eigen::MatrixXd& z, const Eigen::VectorXd& x_N) noexcept;

 private:
  void evaluate() noexcept;
  void subtract_rows(const Eigen::VectorXd& multiplier) noexcept;
  void step(const Eigen::MatrixXd& gradient, const Eigen::VectorXd& gradient_N,
            const Eigen::MatrixXd& defect, const Eigen::VectorXd& extra) noexcept;

  Sizes sizes_;
  QpCost cost_;
  Riccati riccati_;
  QpRows rows_;
  const Eigen::VectorXd* lambda_0_ = nullptr;
  RankOneTerms rank_one_terms_;
  Eigen::MatrixXd z_, z_rest_, gradient_, gradient_rest_, total_, step_;  // (n_z × N)
  Eigen::MatrixXd defect_, defect_rest_;                                  // (n_x × N)
  Eigen::VectorXd x_N_, x_N_rest_, gradient_N_, gradient_N_rest_, total_N_, step_N_;
  Eigen::VectorXd value_, value_rest_, weight_;  // of the rows
  bool factored_ = false;                        // with weight_
};

}  // namespace c3rt::qp
