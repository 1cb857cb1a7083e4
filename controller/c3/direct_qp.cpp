#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <Eigen/Cholesky>

#include "controller/c3/qp.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxRefinements = 4;
constexpr double kConverged = 1e-14;    // gradient beside its largest term
constexpr double kAcceptable = 1e-6;    // worse than this after all refinements: not solved
constexpr double kFirstShift = 1e-14;   // of the largest diagonal entry, where Cholesky breaks down
constexpr int kMaxShifts = 4;           // each 100 times the one before

/// With ν = [λ; u] and B̂ = [D B] the step is a linear-quadratic regulator. `factor` runs the
/// Riccati recursion for the Hessian once; `newton_step` uses it for any gradient, so that the
/// solution is a first Newton step and its refinement the same step again.
class DirectQp final : public QpStep {
 public:
  explicit DirectQp(const Sizes& sizes)
      : sizes_(sizes),
        n_nu_(sizes.n_lambda + sizes.n_u),
        stages_(sizes.N),
        hessian_(sizes.n_z(), sizes.n_z()),
        P_(sizes.n_x, sizes.n_x),
        PA_(sizes.n_x, sizes.n_x),
        PB_(sizes.n_x, n_nu_),
        S_(n_nu_, sizes.n_x),
        gradient_(sizes.n_z(), sizes.N),
        gradient_N_(sizes.n_x),
        difference_(sizes.n_z()),
        p_(sizes.n_x),
        p_next_(sizes.n_x),
        step_x_(sizes.n_x),
        step_x_next_(sizes.n_x),
        step_nu_(n_nu_),
        reduced_(n_nu_) {
    for (Stage& stage : stages_) {
      stage.B_hat.resize(sizes.n_x, n_nu_);
      stage.K = MatrixXd::Zero(n_nu_, sizes.n_x);
      stage.kappa = VectorXd::Zero(n_nu_);
      stage.R_factor = Eigen::LLT<MatrixXd>(n_nu_);
      stage.R_hat.resize(n_nu_, n_nu_);
    }
  }

  void set_costs(const Costs& costs, const Constraints& constraints) override {
    if (any(constraints)) {
      throw std::invalid_argument(
          "Constraints: expected none with the direct QP, got some: use the interior point or OSQP");
    }
    Q_ = costs.Q;
    Q_N_ = costs.Q_N;
    R_ = costs.R;
    factored_rho_ = 0.0;
  }

  void start(Horizon lcs, StageMatrices W, const VectorXd*) noexcept override {
    lcs_ = lcs;
    W_ = W;
    for (int k = 0; k < sizes_.N; ++k) {
      stages_[k].B_hat.leftCols(sizes_.n_lambda) = lcs[k].D;
      stages_[k].B_hat.rightCols(sizes_.n_u) = lcs[k].B;
    }
    factored_rho_ = 0.0;
    started_ = false;
  }

  QpReport solve(double rho, const Eigen::Ref<const VectorXd>& x0,
                 const Eigen::Ref<const MatrixXd>& x_desired, const Eigen::Ref<const MatrixXd>& g,
                 Eigen::Ref<MatrixXd> z, Eigen::Ref<VectorXd> x_N) noexcept override {
    if (rho != factored_rho_ && !factor(rho)) {
      return {QpStatus::kNotFactorable, 0, std::numeric_limits<double>::infinity()};
    }
    if (!started_) z.setZero();
    started_ = true;
    roll_out(x0, z, x_N);
    double residual = compute_gradient(x_desired, g, z, x_N);
    int refinements = -1;  // the first step is the solution, those after it refine
    while (refinements < kMaxRefinements && !(residual <= kConverged && refinements >= 0)) {
      newton_step(z);
      roll_out(x0, z, x_N);
      const double previous = residual;
      residual = compute_gradient(x_desired, g, z, x_N);
      ++refinements;
      if (refinements >= 1 && residual > 0.25 * previous) break;
    }
    const bool solved = residual <= kAcceptable;
    return {solved ? QpStatus::kSolved : QpStatus::kNotFactorable, refinements, residual};
  }

 private:
  struct Stage {
    MatrixXd B_hat;                  // [D B] (n_x × n_nu)
    MatrixXd R_hat;                  // R̂ = H_νν + B̂ᵀ P B̂
    Eigen::LLT<MatrixXd> R_factor;
    MatrixXd K;                      // −R̂⁻¹ (H_νx + B̂ᵀ P A)
    VectorXd kappa;                  // −R̂⁻¹ (gradient)
  };

  bool factor(double rho) noexcept {
    const int n_x = sizes_.n_x;
    factored_rho_ = 0.0;
    P_ = Q_N_;
    for (int k = sizes_.N - 1; k >= 0; --k) {
      hessian_ = rho * W_[k];
      hessian_.topLeftCorner(n_x, n_x) += Q_[k];
      hessian_.bottomRightCorner(sizes_.n_u, sizes_.n_u) += R_[k];
      Stage& stage = stages_[k];
      const MatrixXd& A = lcs_[k].A;
      PB_.noalias() = P_ * stage.B_hat;
      stage.R_hat = hessian_.bottomRightCorner(n_nu_, n_nu_);
      stage.R_hat.noalias() += stage.B_hat.transpose() * PB_;
      if (!factor_shifted(stage)) return false;
      S_ = hessian_.bottomLeftCorner(n_nu_, n_x);
      S_.noalias() += PB_.transpose() * A;
      stage.K = -S_;
      stage.R_factor.solveInPlace(stage.K);
      PA_.noalias() = P_ * A;
      P_ = hessian_.topLeftCorner(n_x, n_x);
      P_.noalias() += A.transpose() * PA_;
      P_.noalias() += S_.transpose() * stage.K;
      // rounding must not let P drift away from symmetry over the horizon
      P_.triangularView<Eigen::StrictlyUpper>() = P_.transpose();
    }
    factored_rho_ = rho;
    return true;
  }

  /// Where rounding makes R̂ indefinite, a tiny shift makes it definite; the refinement, whose
  /// gradient is exact, then removes the shift's error from the solution.
  bool factor_shifted(Stage& stage) noexcept {
    stage.R_factor.compute(stage.R_hat);
    double shift = kFirstShift * stage.R_hat.diagonal().maxCoeff();
    for (int i = 0; i < kMaxShifts && stage.R_factor.info() != Eigen::Success; ++i) {
      stage.R_hat.diagonal().array() += shift;
      stage.R_factor.compute(stage.R_hat);
      shift *= 100.0;
    }
    return stage.R_factor.info() == Eigen::Success;
  }

  /// The states that x0 and the ν of z lead to.
  void roll_out(const Eigen::Ref<const VectorXd>& x0, Eigen::Ref<MatrixXd> z,
                Eigen::Ref<VectorXd> x_N) const noexcept {
    sizes_.x(z.col(0)) = x0;
    for (int k = 0; k < sizes_.N; ++k) {
      auto x_next = k + 1 < sizes_.N ? Eigen::Ref<VectorXd>(z.col(k + 1).head(sizes_.n_x)) : x_N;
      x_next = lcs_[k].d;
      x_next.noalias() += lcs_[k].A * sizes_.x(z.col(k));
      x_next.noalias() += stages_[k].B_hat * z.col(k).tail(n_nu_);
    }
  }

  /// Gradient (halved) of the cost at z, and its reduction to ν by the adjoint recursion: returns
  /// the largest reduced component beside the largest term it is made of.
  double compute_gradient(const Eigen::Ref<const MatrixXd>& x_desired,
                          const Eigen::Ref<const MatrixXd>& g, const Eigen::Ref<const MatrixXd>& z,
                          const Eigen::Ref<const VectorXd>& x_N) noexcept {
    const int n_x = sizes_.n_x;
    for (int k = 0; k < sizes_.N; ++k) {
      difference_ = z.col(k);
      gradient_.col(k).noalias() = W_[k] * difference_;
      gradient_.col(k) -= g.col(k);
      gradient_.col(k) *= factored_rho_;
      step_x_ = sizes_.x(z.col(k)) - x_desired.col(k);
      gradient_.col(k).head(n_x).noalias() += Q_[k] * step_x_;
      gradient_.col(k).tail(sizes_.n_u).noalias() += R_[k] * sizes_.u(z.col(k));
    }
    step_x_ = x_N - x_desired.col(sizes_.N);
    gradient_N_.noalias() = Q_N_ * step_x_;

    double largest = 0.0, scale = 0.0;
    p_ = gradient_N_;
    for (int k = sizes_.N - 1; k >= 0; --k) {
      reduced_.noalias() = stages_[k].B_hat.transpose() * p_;
      scale = std::max({scale, reduced_.cwiseAbs().maxCoeff(),
                        gradient_.col(k).tail(n_nu_).cwiseAbs().maxCoeff()});
      reduced_ += gradient_.col(k).tail(n_nu_);
      largest = std::max(largest, reduced_.cwiseAbs().maxCoeff());
      p_next_.noalias() = lcs_[k].A.transpose() * p_;
      p_ = p_next_ + gradient_.col(k).head(n_x);
    }
    // a state is known to its rounding at best, and the weights magnify that: Q 1e9 beside R 1e-2
    double rounding = 0.0;
    for (int k = 0; k <= sizes_.N; ++k) {
      const MatrixXd& Q = k < sizes_.N ? Q_[k] : Q_N_;
      const double x = std::max(x_desired.col(k).cwiseAbs().maxCoeff(),
                                k < sizes_.N ? sizes_.x(z.col(k)).cwiseAbs().maxCoeff()
                                             : x_N.cwiseAbs().maxCoeff());
      const Stage& into = stages_[std::max(k - 1, 0)];
      rounding = std::max(rounding,
                          into.B_hat.cwiseAbs().maxCoeff() * Q.cwiseAbs().maxCoeff() * x);
    }
    scale = std::max(scale, rounding);
    if (scale == 0.0) return 0.0;
    // a NaN anywhere must not look converged
    return std::isfinite(largest) && gradient_.allFinite()
               ? largest / scale
               : std::numeric_limits<double>::infinity();
  }

  /// Adds to the ν of z the minimiser of the quadratic model with the present gradient.
  void newton_step(Eigen::Ref<MatrixXd> z) noexcept {
    p_ = gradient_N_;
    for (int k = sizes_.N - 1; k >= 0; --k) {
      Stage& stage = stages_[k];
      stage.kappa = gradient_.col(k).tail(n_nu_);
      stage.kappa.noalias() += stage.B_hat.transpose() * p_;
      p_next_ = gradient_.col(k).head(sizes_.n_x);
      p_next_.noalias() += lcs_[k].A.transpose() * p_;
      p_next_.noalias() += stage.K.transpose() * stage.kappa;
      p_.swap(p_next_);
      stage.kappa = -stage.kappa;
      stage.R_factor.solveInPlace(stage.kappa);
    }
    step_x_.setZero();
    for (int k = 0; k < sizes_.N; ++k) {
      const Stage& stage = stages_[k];
      step_nu_ = stage.kappa;
      step_nu_.noalias() += stage.K * step_x_;
      z.col(k).tail(n_nu_) += step_nu_;
      step_x_next_.noalias() = lcs_[k].A * step_x_;
      step_x_next_.noalias() += stage.B_hat * step_nu_;
      step_x_.swap(step_x_next_);
    }
  }

  Sizes sizes_;
  int n_nu_;
  Horizon lcs_{nullptr, 0};
  bool started_ = false;
  double factored_rho_ = 0.0;  // 0: no factorisation
  std::vector<Stage> stages_;
  PerStage<MatrixXd> Q_, R_;
  MatrixXd Q_N_;
  StageMatrices W_{nullptr, 0};
  MatrixXd hessian_;  // ρ W + blkdiag(Q, 0, R), halved Hessian of a stage in z
  MatrixXd P_, PA_, PB_, S_;
  MatrixXd gradient_;     // of stage k in column k (n_z × N)
  VectorXd gradient_N_;   // in x_N
  VectorXd difference_, p_, p_next_, step_x_, step_x_next_, step_nu_, reduced_;
};

}  // namespace

std::unique_ptr<QpStep> make_direct_qp(const Sizes& sizes) {
  return std::make_unique<DirectQp>(sizes);
}

}  // namespace c3rt::c3
