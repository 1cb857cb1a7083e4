#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "controller/qp/active_set.hpp"
#include "controller/qp/infeasibility.hpp"
#include "controller/qp/qp.hpp"
#include "controller/qp/qp_model.hpp"

namespace c3rt::qp {

/// See make_interior_point_qp. First it guesses which rows are active (those of the previous solve
/// since `start`) and takes them as equalities, correcting the guess a few times by the violations
/// and the signs of the multipliers; only if that comes to no end, the interior point iterations
/// [Mehrotra 1992] follow, and a last such guess polishes their answer. Rows with l = u are active
/// always.
class InteriorPointQp final : public QpStep {
 public:
  explicit InteriorPointQp(const Sizes& sizes);
  InteriorPointQp(const InteriorPointQp&) = delete;  // active_ knows the model's rows

  void set_costs(const Costs& costs, const Constraints& constraints) override;
  void start(Horizon lcs, StageMatrices W, const Eigen::VectorXd* lambda_0) noexcept override;
  [[nodiscard]] QpReport solve(double rho, const Eigen::Ref<const Eigen::VectorXd>& x0,
                               const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
                               const Eigen::Ref<const Eigen::MatrixXd>& g,
                               Eigen::Ref<Eigen::MatrixXd> z,
                               Eigen::Ref<Eigen::VectorXd> x_N) noexcept override;

 private:
  using Bound = ActiveSet::Bound;
  /// One finite side of a row that is no equality: sign (aᵀz − bound) = s ≥ 0.
  struct Side {
    int row;
    double sign, bound;
  };

  QpStatus iterate() noexcept;
  void deactivate_all() noexcept;
  bool solve_equalities() noexcept;
  bool factor_penalties() noexcept;
  bool multiplier_step() noexcept;
  void multiplier_step_from_rest() noexcept;
  bool iterate_multipliers() noexcept;
  bool find_active_set() noexcept;
  void guess_active_set() noexcept;
  void start_sides() noexcept;
  bool newton_step() noexcept;
  QpReport check(QpStatus status) noexcept;
  void collect_multipliers() noexcept;

  std::unique_ptr<QpStep> direct_;
  QpModel model_;
  ActiveSet active_;  // of the model's rows
  int iterations_ = 0;
  int n_sides_ = 0;          // with λ_0 fixed some are left out
  std::vector<Side> sides_;  // in the order of the rows
  // per row: aᵀ H⁻¹ a, weight of aaᵀ, multiplier (positive: at the lower bound), extra gradient
  Eigen::VectorXd inverse_hessian_, weight_, multiplier_, extra_;
  double rho_measured_ = 0.0;  // with which these were found
  // per side
  Eigen::VectorXd s_, y_, ds_, dy_, ds_affine_, dy_affine_;
  double violation_ = 0.0;  // the largest at the start of the iterations, in units of √cost
  Infeasibility infeasibility_;
  Eigen::MatrixXd z_kept_;
  Eigen::VectorXd x_N_kept_, multiplier_kept_;
};

}  // namespace c3rt::qp
