#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <osqp.h>

#include "controller/qp/bound.hpp"
#include "controller/qp/qp.hpp"

namespace c3rt::qp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A sparse matrix in compressed columns whose pattern is fixed and whose values are rewritten.
struct Sparse {
  Sparse(int n_rows, int n_cols) : rows(n_rows), cols(n_cols) { column_start.push_back(0); }

  /// Appends an entry to the column being built; returns where its value lies.
  void add(int row, double value) {
    row_index.push_back(row);
    values.push_back(value);
  }
  bool same_pattern(const Sparse& other) const {
    return rows == other.rows && cols == other.cols && column_start == other.column_start &&
           row_index == other.row_index;
  }
  void end_column() { column_start.push_back(static_cast<c_int>(values.size())); }

  csc view() {
    return {static_cast<c_int>(values.size()),
            rows,
            cols,
            column_start.data(),
            row_index.data(),
            values.data(),
            -1};
  }

  c_int rows, cols;
  std::vector<c_int> column_start, row_index;
  std::vector<c_float> values;
};

constexpr double kMargin = 2.0;  // of its tolerance, within which an answer of OSQP is taken

/// Variables [z_0; …; z_{N−1}; x_N]; rows: x_0 = x0, then the N steps, then what is bounded. What
/// OSQP calls solved is checked; where that does not hold, where OSQP says that the constraints
/// cannot be met (which of a problem with far-off numbers it says too easily) or comes to no end,
/// the interior point decides.
class OsqpQp final : public QpStep {
 public:
  OsqpQp(const Sizes& sizes, const OsqpSettings& settings)
      : sizes_(sizes),
        osqp_(settings),
        n_variables_(sizes.N * sizes.n_z() + sizes.n_x),
        q_(VectorXd::Zero(n_variables_)),
        interior_point_(make_interior_point_qp(sizes)),
        stage_(sizes.n_z()),
        difference_(sizes.n_x) {}

  ~OsqpQp() override { osqp_cleanup(work_); }
  OsqpQp(const OsqpQp&) = delete;
  OsqpQp& operator=(const OsqpQp&) = delete;

  void set_costs(const Costs& costs, const Constraints& constraints) override {
    Q_ = costs.Q;
    Q_N_ = costs.Q_N;
    R_ = costs.R;
    interior_point_->set_costs(costs, constraints);
    lay_out_pattern(costs);
    const Sparse P_before = P_, A_before = A_;
    lay_out_bounds(constraints);
    lay_out_cost();
    lay_out_constraints();
    gradient_.setZero(n_variables_);
    row_values_.setZero(static_cast<Eigen::Index>(lower_.size()));
    // the workspace is set up once; weights of the same pattern reach it as updates of the next
    // solve
    if (work_ != nullptr && P_.same_pattern(P_before) && A_.same_pattern(A_before)) return;

    osqp_cleanup(work_);
    work_ = nullptr;
    OSQPSettings settings;
    osqp_set_default_settings(&settings);
    settings.verbose = 0;
    settings.max_iter = osqp_.max_iterations;
    settings.eps_abs = settings.eps_rel = osqp_.eps;
    settings.rho = osqp_.rho;
    settings.adaptive_rho = osqp_.adaptive_rho_interval > 0 ? 1 : 0;
    settings.adaptive_rho_interval = osqp_.adaptive_rho_interval;
    settings.polish = osqp_.polish ? 1 : 0;
    settings.polish_refine_iter = 10;
    q_.setZero();
    csc P = P_.view(), A = A_.view();
    OSQPData data;
    data.n = n_variables_;
    data.m = static_cast<c_int>(lower_.size());
    data.P = &P;
    data.A = &A;
    data.q = q_.data();
    data.l = lower_.data();
    data.u = upper_.data();
    if (const c_int error = osqp_setup(&work_, &data, &settings); error != 0) {
      osqp_cleanup(work_);
      work_ = nullptr;
      throw std::runtime_error("OSQP: set-up failed with error " + std::to_string(error));
    }
  }

  void start(Horizon lcs, StageMatrices W, const VectorXd* lambda_0) noexcept override {
    lcs_ = lcs;
    W_ = W;
    lambda_0_ = lambda_0;
    write_constraints();
    started_ = false;
    weight_rho_ = 0.0;
  }

  QpReport solve(double rho, const Eigen::Ref<const VectorXd>& x0,
                 const Eigen::Ref<const MatrixXd>& x_desired, const Eigen::Ref<const MatrixXd>& g,
                 Eigen::Ref<MatrixXd> z, Eigen::Ref<VectorXd> x_N) noexcept override {
    bool failed = false;
    if (rho != weight_rho_) {
      write_cost(rho);
      // OSQP's scaling looks at q as well; of zero it makes nothing, so no earlier q can show in it
      q_.setZero();
      failed |= osqp_update_lin_cost(work_, q_.data()) != 0;
      failed |= osqp_update_P_A(work_, P_.values.data(), nullptr, P_.values.size(),
                                A_.values.data(), nullptr, A_.values.size()) != 0;
      weight_rho_ = rho;
    }
    if (!started_) {
      // nothing of an earlier problem may show in this one: neither its iterates nor the penalty
      // that OSQP adapted to it
      failed |= osqp_update_rho(work_, osqp_.rho) != 0;
      std::fill(work_->x, work_->x + n_variables_, 0.0);
      std::fill(work_->y, work_->y + lower_.size(), 0.0);
      std::fill(work_->z, work_->z + lower_.size(), 0.0);
      started_ = true;
    }
    write_linear_terms(rho, x0, x_desired, g);
    failed |= osqp_update_lin_cost(work_, q_.data()) != 0;
    failed |= osqp_update_bounds(work_, lower_.data(), upper_.data()) != 0;
    failed |= osqp_solve(work_) != 0;
    if (failed) return {QpStatus::kNotFactorable, 0, kInfinity, kInfinity};
    const OSQPInfo& info = *work_->info;
    const int iterations = static_cast<int>(info.iter);
    if (info.status_val == OSQP_NON_CVX) {
      return {QpStatus::kNotFactorable, iterations, kInfinity, kInfinity};
    }
    if (info.status_val == OSQP_SOLVED) {
      const QpReport report = check(iterations);
      if (report.status == QpStatus::kSolved) {
        const Eigen::Map<const VectorXd> solution(work_->solution->x, n_variables_);
        for (int k = 0; k < sizes_.N; ++k) {
          z.col(k) = solution.segment(k * sizes_.n_z(), sizes_.n_z());
        }
        x_N = solution.tail(sizes_.n_x);
        return report;
      }
    }
    started_ = false;
    interior_point_->start(lcs_, W_, lambda_0_);
    QpReport report = interior_point_->solve(rho, x0, x_desired, g, z, x_N);
    report.iterations += iterations;
    return report;
  }

 private:
  /// The optimality conditions of OSQP's answer in the problem as it was given, relative as OSQP's
  /// tolerances are: beside 1 and the largest entry of their vectors.
  QpReport check(int iterations) noexcept {
    QpReport report{QpStatus::kNotConverged, iterations, kInfinity, kInfinity};
    const double *x = work_->solution->x, *y = work_->solution->y;
    gradient_ = q_;
    row_values_.setZero();
    double dual_terms = 1.0, primal_terms = 1.0, outside = 0.0, left = 0.0;
    // P z, of whose triangle each entry counts twice but on the diagonal
    multiply_P(x);
    for (int j = 0; j < n_variables_; ++j) {
      double constraint_force = 0.0;
      for (c_int e = A_.column_start[j]; e < A_.column_start[j + 1]; ++e) {
        row_values_[A_.row_index[e]] += A_.values[e] * x[j];
        constraint_force += A_.values[e] * y[A_.row_index[e]];
      }
      dual_terms = std::max(
          {dual_terms, std::abs(gradient_[j]), std::abs(q_[j]), std::abs(constraint_force)});
      gradient_[j] += constraint_force;
      left = larger(left, std::abs(gradient_[j]));
    }
    for (Eigen::Index i = 0; i < row_values_.size(); ++i) {
      const double value = row_values_[i];
      primal_terms = std::max(primal_terms, std::abs(value));
      outside = larger(outside, std::max({0.0, lower_[i] - value, value - upper_[i]}));
    }
    report.primal_residual = outside / primal_terms;
    report.dual_residual = left / dual_terms;
    // a multiplier away from the bound that it belongs to
    for (Eigen::Index i = 0; i < row_values_.size(); ++i) {
      const double inside = y[i] > 0.0 ? upper_[i] - row_values_[i] : row_values_[i] - lower_[i];
      report.dual_residual = larger(report.dual_residual,
                                    std::min(std::abs(y[i]) / dual_terms, inside / primal_terms));
    }
    const double tolerance = kMargin * osqp_.eps;
    if (report.primal_residual <= tolerance && report.dual_residual <= tolerance) {
      report.status = QpStatus::kSolved;
    }
    return report;
  }

  /// gradient_ += P x.
  void multiply_P(const double* x) noexcept {
    for (int j = 0; j < n_variables_; ++j) {
      for (c_int e = P_.column_start[j]; e < P_.column_start[j + 1]; ++e) {
        const c_int i = P_.row_index[e];
        gradient_[i] += P_.values[e] * x[j];
        if (i != j) gradient_[j] += P_.values[e] * x[i];
      }
    }
  }

  /// A maximum that keeps NaN.
  static double larger(double a, double b) noexcept { return a > b || std::isnan(a) ? a : b; }

  /// Bound of coordinate i of z_k.
  static double bound_of(const VectorXd& x, const VectorXd& lambda, const VectorXd& u,
                         const Sizes& sizes, int i, double none) {
    if (i < sizes.n_x) return bound_at(x, i, none);
    if (i < sizes.n_x + sizes.n_lambda) return bound_at(lambda, i - sizes.n_x, none);
    return bound_at(u, i - sizes.n_x - sizes.n_lambda, none);
  }

  /// Every λ_0 has a row, so that it can be fixed without another pattern.
  void lay_out_bounds(const Constraints& c) {
    const int n_x = sizes_.n_x, n_z = sizes_.n_z();
    const int n_equalities = (sizes_.N + 1) * n_x;
    lower_.assign(n_equalities, 0.0);
    upper_.assign(n_equalities, 0.0);
    bound_row_.assign(sizes_.N * n_z + n_x, -1);
    const auto add = [this](double lower, double upper) {
      // both ways: what is beyond OSQP's infinity on the wrong side cannot be met, nor is it set up
      lower_.push_back(std::clamp(lower, -OSQP_INFTY, OSQP_INFTY));
      upper_.push_back(std::clamp(upper, -OSQP_INFTY, OSQP_INFTY));
    };
    for (int k = 0; k < sizes_.N; ++k) {
      for (int i = k == 0 ? n_x : 0; i < n_z; ++i) {  // x_0 is given
        const double lower =
            bound_of(c.x_min[k], c.lambda_min[k], c.u_min[k], sizes_, i, -kInfinity);
        const double upper =
            bound_of(c.x_max[k], c.lambda_max[k], c.u_max[k], sizes_, i, kInfinity);
        const bool is_lambda_0 = k == 0 && i < n_x + sizes_.n_lambda;
        if (lower == -kInfinity && upper == kInfinity && !is_lambda_0) continue;
        bound_row_[k * n_z + i] = static_cast<int>(lower_.size());
        add(lower, upper);
      }
    }
    for (int i = 0; i < n_x; ++i) {
      const double lower = bound_at(c.x_N_min, i, -kInfinity),
                   upper = bound_at(c.x_N_max, i, kInfinity);
      if (lower == -kInfinity && upper == kInfinity) continue;
      bound_row_[sizes_.N * n_z + i] = static_cast<int>(lower_.size());
      add(lower, upper);
    }
    C_ = c.C;
    first_row_.assign(sizes_.N, 0);
    for (int k = 0; k < sizes_.N; ++k) {
      first_row_[k] = static_cast<int>(lower_.size());
      for (Eigen::Index row = 0; row < C_[k].rows(); ++row) {
        const bool of_x_0 = k == 0 && C_[k].row(row).tail(n_z - n_x).isZero(0.0);
        add(of_x_0 ? -kInfinity : bound_at(c.C_min[k], row, -kInfinity),
            of_x_0 ? kInfinity : bound_at(c.C_max[k], row, kInfinity));
      }
    }
    first_lambda_0_ = bound_row_[n_x];
    bounds_of_lambda_0_.resize(sizes_.n_lambda, 2);
    for (int i = 0; i < sizes_.n_lambda; ++i) {
      bounds_of_lambda_0_.row(i) << lower_[first_lambda_0_ + i], upper_[first_lambda_0_ + i];
    }
  }

  /// Where costs and consensus term of a stage may have entries; C3+ fills its part with [E F H].
  void lay_out_pattern(const Costs& costs) {
    const int n_z = sizes_.n_z();
    in_cost_.setIdentity(n_z, n_z);
    for (int k = 0; k < sizes_.N; ++k) {
      in_cost_.topLeftCorner(sizes_.n_x, sizes_.n_x) += Q_[k].cwiseAbs();
      in_cost_.bottomRightCorner(sizes_.n_u, sizes_.n_u) += R_[k].cwiseAbs();
      if (costs.G[k].size() == 0) {
        in_cost_.setOnes();
      } else {
        in_cost_ += costs.G[k].cwiseAbs();
      }
    }
  }

  /// Upper triangle of the Hessian; zeros of all its parts are left out for good.
  void lay_out_cost() {
    P_ = Sparse(n_variables_, n_variables_);
    const int n_z = sizes_.n_z();
    for (int k = 0; k < sizes_.N; ++k) {
      for (int col = 0; col < n_z; ++col) {
        for (int row = 0; row <= col; ++row) {
          if (in_cost_(row, col) != 0.0) P_.add(k * n_z + row, row == col ? 1.0 : 0.0);
        }
        P_.end_column();
      }
    }
    for (int col = 0; col < sizes_.n_x; ++col) {
      for (int row = 0; row <= col; ++row) {
        if (row == col || Q_N_(row, col) != 0.0) {
          P_.add(sizes_.N * n_z + row, 2.0 * Q_N_(row, col));
        }
      }
      P_.end_column();
    }
  }

  void write_cost(double rho) noexcept {
    std::size_t at = 0;
    const int n_x = sizes_.n_x, n_z = sizes_.n_z(), n_nu = n_x + sizes_.n_lambda;
    for (int k = 0; k < sizes_.N; ++k) {
      for (int col = 0; col < n_z; ++col) {
        for (int row = 0; row <= col; ++row) {
          if (in_cost_(row, col) == 0.0) continue;
          double value = rho * W_[k](row, col);
          if (col < n_x) value += Q_[k](row, col);
          if (row >= n_nu) value += R_[k](row - n_nu, col - n_nu);
          P_.values[at++] = 2.0 * value;
        }
      }
    }
    for (int col = 0; col < n_x; ++col) {
      for (int row = 0; row <= col; ++row) {
        if (row == col || Q_N_(row, col) != 0.0) P_.values[at++] = 2.0 * Q_N_(row, col);
      }
    }
  }

  /// The blocks [A D B] are laid out full, so that any system fits the pattern.
  void lay_out_constraints() {
    A_ = Sparse(static_cast<int>(lower_.size()), n_variables_);
    const int n_x = sizes_.n_x, n_z = sizes_.n_z();
    for (int k = 0; k < sizes_.N; ++k) {
      for (int col = 0; col < n_z; ++col) {
        if (col < n_x) A_.add(k * n_x + col, -1.0);
        for (int row = 0; row < n_x; ++row) A_.add((k + 1) * n_x + row, 0.0);
        if (const int row = bound_row_[k * n_z + col]; row >= 0) A_.add(row, 1.0);
        for (Eigen::Index row = 0; row < C_[k].rows(); ++row) {
          if (C_[k](row, col) != 0.0) {
            A_.add(first_row_[k] + static_cast<int>(row), C_[k](row, col));
          }
        }
        A_.end_column();
      }
    }
    for (int col = 0; col < n_x; ++col) {
      A_.add(sizes_.N * n_x + col, -1.0);
      if (const int row = bound_row_[sizes_.N * n_z + col]; row >= 0) A_.add(row, 1.0);
      A_.end_column();
    }
  }

  void write_constraints() noexcept {
    const int n_x = sizes_.n_x, n_z = sizes_.n_z();
    for (int k = 0; k < sizes_.N; ++k) {
      for (int col = 0; col < n_z; ++col) {
        double* values = &A_.values[A_.column_start[k * n_z + col]];
        if (col < n_x) ++values;  // the −1 of x_k
        const auto block = col < n_x ? lcs_[k].A.col(col)
                           : col < n_x + sizes_.n_lambda
                               ? lcs_[k].D.col(col - n_x)
                               : lcs_[k].B.col(col - n_x - sizes_.n_lambda);
        std::copy_n(block.data(), n_x, values);
      }
    }
  }

  void write_linear_terms(double rho, const Eigen::Ref<const VectorXd>& x0,
                          const Eigen::Ref<const MatrixXd>& x_desired,
                          const Eigen::Ref<const MatrixXd>& g) noexcept {
    const int n_x = sizes_.n_x, n_z = sizes_.n_z();
    for (int k = 0; k < sizes_.N; ++k) {
      stage_ = rho * g.col(k);
      difference_ = x_desired.col(k);
      stage_.head(n_x).noalias() += Q_[k] * difference_;
      q_.segment(k * n_z, n_z) = -2.0 * stage_;
    }
    difference_.noalias() = Q_N_ * x_desired.col(sizes_.N);
    q_.tail(n_x) = -2.0 * difference_;
    for (int i = 0; i < n_x; ++i) lower_[i] = upper_[i] = -x0[i];
    for (int k = 0; k < sizes_.N; ++k) {
      for (int i = 0; i < n_x; ++i) {
        lower_[(k + 1) * n_x + i] = upper_[(k + 1) * n_x + i] = -lcs_[k].d[i];
      }
    }
    for (int i = 0; i < sizes_.n_lambda; ++i) {
      const bool fixed = lambda_0_ != nullptr;
      lower_[first_lambda_0_ + i] = fixed ? (*lambda_0_)[i] : bounds_of_lambda_0_(i, 0);
      upper_[first_lambda_0_ + i] = fixed ? (*lambda_0_)[i] : bounds_of_lambda_0_(i, 1);
    }
  }

  Sizes sizes_;
  OsqpSettings osqp_;
  int n_variables_;
  PerStage<MatrixXd> Q_, R_, C_;
  MatrixXd Q_N_;
  MatrixXd in_cost_;  // not zero where the cost of a stage may have an entry (n_z × n_z)
  Sparse P_{0, 0}, A_{0, 0};
  std::vector<int> bound_row_;  // of coordinate i of z_k at k n_z + i, then of x_N; or −1
  std::vector<int> first_row_;  // of the rows C of stage k
  int first_lambda_0_ = 0;
  Eigen::Matrix<double, Eigen::Dynamic, 2> bounds_of_lambda_0_;
  VectorXd q_;
  std::vector<c_float> lower_, upper_;
  Horizon lcs_{nullptr, 0};
  StageMatrices W_{nullptr, 0};
  const VectorXd* lambda_0_ = nullptr;
  bool started_ = false;
  double weight_rho_ = 0.0;
  OSQPWorkspace* work_ = nullptr;
  VectorXd gradient_, row_values_;
  std::unique_ptr<QpStep> interior_point_;
  VectorXd stage_, difference_;
};

}  // namespace

std::unique_ptr<QpStep> make_osqp_qp(const Sizes& sizes, const OsqpSettings& settings) {
  return std::make_unique<OsqpQp>(sizes, settings);
}

}  // namespace c3rt::qp
