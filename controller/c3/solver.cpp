#include "controller/c3/solver.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool has_sizes(const lcs::Lcs& lcs, const Sizes& s) {
  const auto is = [](const auto& block, int rows, int cols) {
    return block.rows() == rows && block.cols() == cols;
  };
  return is(lcs.A, s.n_x, s.n_x) && is(lcs.B, s.n_x, s.n_u) && is(lcs.D, s.n_x, s.n_lambda) &&
         is(lcs.d, s.n_x, 1) && is(lcs.E, s.n_lambda, s.n_x) &&
         is(lcs.F, s.n_lambda, s.n_lambda) && is(lcs.H, s.n_lambda, s.n_u) &&
         is(lcs.c, s.n_lambda, 1);
}

bool is_finite(const lcs::Lcs& lcs) {
  return lcs.A.allFinite() && lcs.B.allFinite() && lcs.D.allFinite() && lcs.d.allFinite() &&
         lcs.E.allFinite() && lcs.F.allFinite() && lcs.H.allFinite() && lcs.c.allFinite();
}

}  // namespace

void check(const Settings& settings) {
  const auto require = [](bool met, const char* what, const std::string& got) {
    if (!met) throw std::invalid_argument("Settings." + std::string(what) + ", got " + got);
  };
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  require(settings.admm_iterations >= 1, "admm_iterations: expected 1 or more",
          std::to_string(settings.admm_iterations));
  require(positive(settings.rho), "rho: expected a positive number", std::to_string(settings.rho));
  require(positive(settings.rho_scale), "rho_scale: expected a positive number",
          std::to_string(settings.rho_scale));
  require(settings.max_nodes >= 1, "max_nodes: expected 1 or more",
          std::to_string(settings.max_nodes));
  if (settings.qp == QpBackend::kOsqp) {
    const OsqpSettings& osqp = settings.osqp;
    require(osqp.max_iterations >= 1, "osqp.max_iterations: expected 1 or more",
            std::to_string(osqp.max_iterations));
    require(positive(osqp.eps), "osqp.eps: expected a positive number", std::to_string(osqp.eps));
    require(positive(osqp.rho), "osqp.rho: expected a positive number", std::to_string(osqp.rho));
    require(osqp.adaptive_rho_interval >= 0, "osqp.adaptive_rho_interval: expected 0 or more",
            std::to_string(osqp.adaptive_rho_interval));
  }
}

Solver::Solver(const Sizes& sizes, const Settings& settings) : sizes_(sizes), settings_(settings) {
  check(sizes);
  check(settings);
  qp_ = settings.qp == QpBackend::kOsqp ? make_osqp_qp(sizes, settings.osqp)
                                        : make_direct_qp(sizes);
  projection_ = settings.projection == ProjectionKind::kLcp
                    ? make_lcp_projection(sizes)
                    : make_miqp_projection(sizes, settings.max_nodes);
  for (MatrixXd* m : {&z_, &delta_, &r_, &solution_.z, &solution_.delta, &solution_.w}) {
    m->setZero(sizes.n_z(), sizes.N);
  }
  x_N_.setZero(sizes.n_x);
  v_.setZero(sizes.n_z());
  y_.setZero(sizes.n_lambda);
  solution_.x_N.setZero(sizes.n_x);
  solution_.primal_residual.setZero(settings.admm_iterations);
  solution_.n_u = sizes.n_u;
  reset();
}

void Solver::set_costs(const Costs& costs, const Bounds& bounds) {
  check(costs, sizes_);
  check(bounds, sizes_);
  has_costs_ = false;
  qp_->set_costs(costs, bounds);
  projection_->set_weight(costs.U);
  has_costs_ = true;
}

const Solution& Solver::solve(const lcs::Lcs& lcs, const Eigen::Ref<const VectorXd>& x0,
                              const Eigen::Ref<const MatrixXd>& x_desired,
                              const Deadline& deadline) noexcept {
  return run({&lcs, 0}, x0, x_desired, deadline);
}

const Solution& Solver::solve(const std::vector<lcs::Lcs>& lcs,
                              const Eigen::Ref<const VectorXd>& x0,
                              const Eigen::Ref<const MatrixXd>& x_desired,
                              const Deadline& deadline) noexcept {
  if (static_cast<int>(lcs.size()) != sizes_.N) {
    reset();
    return fail(Failure::kWrongSize);
  }
  return run({lcs.data(), 1}, x0, x_desired, deadline);
}

Failure Solver::refuse(Horizon lcs, const Eigen::Ref<const VectorXd>& x0,
                       const Eigen::Ref<const MatrixXd>& x_desired) const noexcept {
  if (!has_costs_) return Failure::kNoCosts;
  if (x0.size() != sizes_.n_x || x_desired.rows() != sizes_.n_x ||
      x_desired.cols() != sizes_.N + 1) {
    return Failure::kWrongSize;
  }
  if (!x0.allFinite() || !x_desired.allFinite()) return Failure::kNotFinite;
  const int systems = lcs.stride == 0 ? 1 : sizes_.N;
  for (int k = 0; k < systems; ++k) {
    if (!has_sizes(lcs[k], sizes_)) return Failure::kWrongSize;
    if (!is_finite(lcs[k])) return Failure::kNotFinite;
  }
  return Failure::kNone;
}

const Solution& Solver::run(Horizon lcs, const Eigen::Ref<const VectorXd>& x0,
                            const Eigen::Ref<const MatrixXd>& x_desired,
                            const Deadline& deadline) noexcept {
  reset();
  if (const Failure failure = refuse(lcs, x0, x_desired); failure != Failure::kNone) {
    return fail(failure);
  }
  qp_->start(lcs);
  if (lcs.stride == 0) projection_->start(lcs[0]);
  if (settings_.delta_starts_at_x0) solution_.delta.topRows(sizes_.n_x).colwise() = x0;

  solution_.status = SolveStatus::kOk;
  double rho = settings_.rho;
  for (int i = 0; i < settings_.admm_iterations; ++i) {
    r_ = solution_.delta - solution_.w;
    solution_.qp = qp_->solve(rho, x0, x_desired, r_, z_, x_N_);         // [C3, eq. (21)]
    if (solution_.qp.status == QpStatus::kInfeasible ||
        solution_.qp.status == QpStatus::kNotFactorable) {
      return fail(Failure::kQp);
    }
    if (!z_.allFinite() || !x_N_.allFinite()) return fail(Failure::kNotFinite);
    solution_.z = z_;
    solution_.x_N = x_N_;
    ++solution_.iterations;
    const bool last = i + 1 == settings_.admm_iterations;
    if (last && !settings_.project_last) break;

    if (!project(lcs, deadline)) break;                                  // [C3, eq. (22), (23)]
    solution_.w = (solution_.w + solution_.z - solution_.delta) / settings_.rho_scale;
    rho *= settings_.rho_scale;
    if (!last && deadline.struck()) {
      solution_.status = SolveStatus::kTruncated;
      break;
    }
  }
  if (solution_.status == SolveStatus::kFailed) return fail(solution_.failure);
  solution_.complementarity_violation = complementarity_violation(lcs);
  return solution_;
}

bool Solver::project(Horizon lcs, const Deadline& deadline) noexcept {
  for (int k = 0; k < sizes_.N; ++k) {
    if (deadline.struck()) {
      solution_.status = SolveStatus::kTruncated;
      return false;
    }
    if (lcs.stride != 0) projection_->start(lcs[k]);
    v_ = solution_.z.col(k) + solution_.w.col(k);
    const ProjectionReport report = projection_->project(v_, delta_.col(k), deadline);
    solution_.branch_nodes += report.nodes;
    if (report.status == ProjectionStatus::kDeadline) {
      solution_.status = SolveStatus::kTruncated;
      return false;
    }
    if (report.status == ProjectionStatus::kNone ||
        report.status == ProjectionStatus::kNotFinite) {
      // the deadline may be why there is no point yet
      const bool late = report.status == ProjectionStatus::kNone && deadline.struck();
      solution_.status = late ? SolveStatus::kTruncated : SolveStatus::kFailed;
      solution_.failure = late ? Failure::kNone : Failure::kProjection;
      return false;
    }
    if (report.status == ProjectionStatus::kNodeLimit) {
      ++solution_.inexact_projections;
      solution_.status = SolveStatus::kTruncated;
    }
  }
  solution_.delta = delta_;
  solution_.primal_residual[solution_.projections] = (solution_.z - solution_.delta).norm();
  ++solution_.projections;
  return true;
}

double Solver::complementarity_violation(Horizon lcs) noexcept {
  double worst = 0.0;
  for (int k = 0; k < sizes_.N; ++k) {
    const auto z_k = solution_.z.col(k);
    y_ = lcs[k].c;
    y_.noalias() += lcs[k].E * sizes_.x(z_k);
    y_.noalias() += lcs[k].F * sizes_.lambda(z_k);
    y_.noalias() += lcs[k].H * sizes_.u(z_k);
    worst = std::max(worst, y_.cwiseMin(sizes_.lambda(z_k)).cwiseAbs().maxCoeff());
  }
  return worst;
}

void Solver::reset() noexcept {
  solution_.status = SolveStatus::kFailed;
  solution_.failure = Failure::kNone;
  solution_.z.setZero();
  solution_.x_N.setZero();
  solution_.delta.setZero();
  solution_.w.setZero();
  solution_.primal_residual.setZero();
  solution_.complementarity_violation = 0.0;
  solution_.iterations = solution_.projections = solution_.inexact_projections = 0;
  solution_.branch_nodes = 0;
  solution_.qp = {};
}

const Solution& Solver::fail(Failure failure) noexcept {
  solution_.status = SolveStatus::kFailed;
  solution_.failure = failure;
  solution_.z.setZero();
  solution_.x_N.setZero();
  return solution_;
}

}  // namespace c3rt::c3
