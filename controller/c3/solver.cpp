#include "controller/c3/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "controller/c3/projection/registry.hpp"
#include "controller/lcs/step.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool has_sizes(const lcs::Lcs& lcs, const Sizes& s) {
  const auto is = [](const auto& block, int rows, int cols) {
    return block.rows() == rows && block.cols() == cols;
  };
  return is(lcs.A, s.n_x, s.n_x) && is(lcs.B, s.n_x, s.n_u) && is(lcs.D, s.n_x, s.n_lambda) &&
         is(lcs.d, s.n_x, 1) && is(lcs.E, s.n_lambda, s.n_x) && is(lcs.F, s.n_lambda, s.n_lambda) &&
         is(lcs.H, s.n_lambda, s.n_u) && is(lcs.c, s.n_lambda, 1);
}

std::unique_ptr<QpStep> make_qp(const Sizes& sizes, const Settings& settings) {
  switch (settings.qp) {
    case QpBackend::kOsqp:
      return qp::make_osqp_qp(sizes, settings.osqp);
    case QpBackend::kInteriorPoint:
      return qp::make_interior_point_qp(sizes);
    case QpBackend::kDirect:
      break;
  }
  return qp::make_direct_qp(sizes);
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
  require(settings.polish >= 0, "polish: expected 0 or more", std::to_string(settings.polish));
  const ProjectionType& type = projection_type(settings.projection);
  if (type.check_settings != nullptr) type.check_settings(settings);
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

Solver::Solver(const Sizes& sizes, const Settings& settings, const Parallel& parallel)
    : sizes_(sizes),
      settings_(settings),
      parallel_(parallel),
      consensus_(projection_type(settings.projection).make_consensus(sizes)),
      n_copy_(consensus_->n_copy()),
      lemke_(sizes.n_lambda) {
  check(sizes);
  check(settings);
  qp_ = make_qp(sizes, settings);
  const int workers = parallel.run == nullptr ? 1 : std::max(1, parallel.workers);
  for (int i = 0; i < workers; ++i) workers_.push_back({make_projection(sizes, settings), nullptr});
  if (settings.polish > 0 && sizes.n_lambda > 0 && sizes.n_u > 0)
    polish_ = std::make_unique<Polish>(sizes, settings.polish);
  solution_.modes.resize(sizes.n_lambda, sizes.N);
  for (MatrixXd* m : {&delta_, &v_, &solution_.z, &solution_.delta, &solution_.w}) {
    m->setZero(n_copy_, sizes.N);
  }
  z_.setZero(sizes.n_z(), sizes.N);
  g_.setZero(sizes.n_z(), sizes.N);
  x_N_.setZero(sizes.n_x);
  y_.setZero(sizes.n_lambda);
  lambda_0_.setZero(sizes.n_lambda);
  reports_.resize(sizes.N);
  solution_.x_N.setZero(sizes.n_x);
  solution_.primal_residual.setZero(settings.admm_iterations);
  solution_.sizes = sizes;
  if (settings.trace) {
    const MatrixXd copy = MatrixXd::Zero(n_copy_, sizes.N);
    solution_.trace.assign(settings.admm_iterations,
                           {0.0, copy, x_N_, copy, copy, {}, 0, reports_, 0.0, 0.0, 0.0});
  }
  reset();
}

void Solver::set_costs(const Costs& costs, const Constraints& constraints) {
  check(costs, sizes_, settings_.projection);
  check(constraints, sizes_);
  has_costs_ = false;
  qp::Costs of_qp = costs;
  of_qp.G = consensus_->pattern(costs);
  qp_->set_costs(of_qp, constraints);
  for (const Worker& worker : workers_) worker.projection->set_weights(costs);
  consensus_->set_weights(costs);
  if (polish_ != nullptr) polish_->set_costs(costs, constraints);
  has_costs_ = true;
}

const Solution& Solver::solve(const lcs::Lcs& lcs, const Eigen::Ref<const VectorXd>& x0,
                              const Eigen::Ref<const MatrixXd>& x_desired, const Deadline& deadline,
                              const Start* start) noexcept {
  return run({&lcs, 0}, x0, x_desired, deadline, start);
}

const Solution& Solver::solve(const std::vector<lcs::Lcs>& lcs,
                              const Eigen::Ref<const VectorXd>& x0,
                              const Eigen::Ref<const MatrixXd>& x_desired, const Deadline& deadline,
                              const Start* start) noexcept {
  if (static_cast<int>(lcs.size()) != sizes_.N) {
    reset();
    return fail(Failure::kWrongSize);
  }
  return run({lcs.data(), 1}, x0, x_desired, deadline, start);
}

Failure Solver::refuse(Horizon lcs, const Eigen::Ref<const VectorXd>& x0,
                       const Eigen::Ref<const MatrixXd>& x_desired,
                       const Start* start) const noexcept {
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
  if (start == nullptr) return Failure::kNone;
  if (start->u.size() != 0) {
    if (start->u.rows() != sizes_.n_u || start->u.cols() != sizes_.N) return Failure::kWrongSize;
    if (!start->u.allFinite()) return Failure::kNotFinite;
  }
  if (start->modes.size() != 0) {
    if (start->modes.rows() != sizes_.n_lambda || start->modes.cols() != sizes_.N)
      return Failure::kWrongSize;
  }
  if (start->delta.size() == 0 && start->w.size() == 0) return Failure::kNone;
  for (const MatrixXd* m : {&start->delta, &start->w}) {
    if (m->rows() != n_copy_ || m->cols() != sizes_.N) return Failure::kWrongSize;
    if (!m->allFinite()) return Failure::kNotFinite;
  }
  return Failure::kNone;
}

const Solution& Solver::run(Horizon lcs, const Eigen::Ref<const VectorXd>& x0,
                            const Eigen::Ref<const MatrixXd>& x_desired, const Deadline& deadline,
                            const Start* start) noexcept {
  reset();
  if (const Failure failure = refuse(lcs, x0, x_desired, start); failure != Failure::kNone) {
    return fail(failure);
  }
  if (settings_.fix_lambda_0) {
    if (const Failure failure = find_lambda_0(lcs[0], x0); failure != Failure::kNone) {
      return fail(failure);
    }
  }
  qp_->start(lcs, consensus_->start(lcs), fixed_lambda_0());
  for (Worker& worker : workers_) worker.lcs = nullptr;
  if (start != nullptr && start->delta.size() != 0) {
    solution_.delta = start->delta;
    solution_.w = start->w;
  } else if (settings_.delta_starts_at_x0) {
    solution_.delta.topRows(sizes_.n_x).colwise() = x0;
  }

  solution_.status = SolveStatus::kOk;
  for (int i = 0; i < settings_.admm_iterations; ++i) {
    const double rho = solution_.rho;
    const bool last = i + 1 == settings_.admm_iterations;
    if (last && i > 0 && finish(lcs)) {
      v_.setZero();
      consensus_->set_linear_term(solution_.delta, v_, g_);
    } else {
      consensus_->set_linear_term(solution_.delta, solution_.w, g_);
    }
    solution_.qp = qp_->solve(rho, x0, x_desired, g_, z_, x_N_);  // [C3, eq. (21)]
    if (solution_.qp.status != QpStatus::kSolved) return fail(Failure::kQp);
    if (!z_.allFinite() || !x_N_.allFinite()) return fail(Failure::kNotFinite);
    solution_.z.topRows(sizes_.n_z()) = z_;
    solution_.x_N = x_N_;
    consensus_->append(solution_.z);
    ++solution_.iterations;
    if (last && !settings_.project_last) {
      record(lcs, rho, false);
      break;
    }
    if (!project(lcs, deadline)) {  // [C3, eq. (22) – (24)]
      record(lcs, rho, false);
      break;
    }
    solution_.w = (solution_.w + solution_.z - solution_.delta) / settings_.rho_scale;
    solution_.rho *= settings_.rho_scale;
    record(lcs, rho, true);
    if (!last && deadline.struck()) {
      solution_.status = SolveStatus::kTruncated;
      break;
    }
  }
  if (solution_.status == SolveStatus::kFailed) return fail(solution_.failure);
  if (polish_ != nullptr) polish(lcs, x0, x_desired, deadline, start);
  solution_.complementarity_violation = complementarity_violation(lcs);
  const bool finite = solution_.z.allFinite() && solution_.delta.allFinite() &&
                      solution_.w.allFinite() && std::isfinite(solution_.complementarity_violation);
  return finite ? solution_ : fail(Failure::kNotFinite);
}

const VectorXd* Solver::fixed_lambda_0() const noexcept {
  return settings_.fix_lambda_0 ? &lambda_0_ : nullptr;
}

/// The last QP goes towards δ itself: false where it is as the others.
bool Solver::finish(Horizon lcs) noexcept {
  const StageMatrices W = consensus_->finish(solution_.delta);
  if (W.first == nullptr) return false;
  qp_->start(lcs, W, fixed_lambda_0());
  return true;
}

void Solver::polish(Horizon lcs, const Eigen::Ref<const VectorXd>& x0,
                    const Eigen::Ref<const MatrixXd>& x_desired, const Deadline& deadline,
                    const Start* start) noexcept {
  const int n_x = sizes_.n_x, n_lambda = sizes_.n_lambda, n_u = sizes_.n_u, N = sizes_.N;
  const auto inputs = z_.bottomRows(n_u);
  polish_->start(lcs, x0, x_desired, inputs, solution_.delta.middleRows(n_x, n_lambda));
  const bool is_known = start != nullptr && start->u.size() != 0;
  const bool is_better =
      is_known && start->modes.size() != 0 && polish_->resume(start->u, start->modes, deadline);
  if (is_known && !is_better) polish_->improve(start->u, deadline);
  polish_->improve(inputs, deadline);
  // each of them meets its stage's pairs, which Algorithm 1's need not
  if (!is_better) polish_->improve(solution_.delta.middleRows(n_x + n_lambda, n_u), deadline);
  polish_->explore(deadline);
  solution_.polish = polish_->report();
  if (!std::isfinite(solution_.polish.cost)) return;
  solution_.z.topRows(n_x) = polish_->x().leftCols(N);
  solution_.z.middleRows(n_x, n_lambda) = polish_->lambda();
  solution_.z.middleRows(n_x + n_lambda, n_u) = polish_->u();
  solution_.x_N = polish_->x().col(N);
  polish_->read_modes(solution_.modes);
  consensus_->append(solution_.z);
}

Failure Solver::find_lambda_0(const lcs::Lcs& lcs, const Eigen::Ref<const VectorXd>& x0) noexcept {
  if (!lcs.H.isZero(0.0)) return Failure::kLambda0;
  const lcs::LcpReport report = lcs::solve_lcp(lcs, x0, lemke_, lambda_0_);
  return report.status == lcs::LcpStatus::kSolved ? Failure::kNone : Failure::kLambda0;
}

void Solver::project_stage(void* round, int k, int worker) noexcept {
  const Round& r = *static_cast<const Round*>(round);
  Solver& solver = *r.solver;
  ProjectionReport& report = solver.reports_[k];
  if (r.deadline->struck()) {
    report = {ProjectionStatus::kDeadline, 0, 0.0};
    return;
  }
  Worker& w = solver.workers_[worker];
  const lcs::Lcs& lcs = r.lcs[k];
  if (w.lcs != &lcs) w.projection->start(lcs);
  w.lcs = &lcs;
  report = w.projection->project(solver.v_.col(k), solver.delta_.col(k), *r.deadline);
}

bool Solver::project(Horizon lcs, const Deadline& deadline) noexcept {
  v_ = solution_.z + solution_.w;
  Round round{this, lcs, &deadline};
  if (workers_.size() > 1) {
    parallel_.run(parallel_.pool, sizes_.N, &Solver::project_stage, &round);
  } else {
    for (int k = 0; k < sizes_.N; ++k) project_stage(&round, k, 0);
  }
  bool late = false, failed = false, inexact = false;
  for (int k = 0; k < sizes_.N; ++k) {
    const ProjectionReport& report = reports_[k];
    solution_.branch_nodes += report.nodes;
    late |= report.status == ProjectionStatus::kDeadline;
    if (!failed && !has_point(report.status)) {
      failed = true;
      solution_.projection = report;
      solution_.failed_stage = k;
    }
    if (report.status == ProjectionStatus::kNodeLimit) {
      ++solution_.inexact_projections;
      inexact = true;
    }
  }
  // the deadline may be why one of them has no point yet
  late |= failed && deadline.struck();
  if (late || failed) {
    solution_.status = late ? SolveStatus::kTruncated : SolveStatus::kFailed;
    solution_.failure = late ? Failure::kNone : Failure::kProjection;
    return false;
  }
  if (inexact) solution_.status = SolveStatus::kTruncated;
  if (settings_.trace) dual_residual_ = solution_.rho * (delta_ - solution_.delta).norm();
  solution_.delta = delta_;
  solution_.primal_residual[solution_.projections] = (solution_.z - solution_.delta).norm();
  ++solution_.projections;
  return true;
}

void Solver::record(Horizon lcs, double rho, bool projected) noexcept {
  if (!settings_.trace) return;
  Iterate& iterate = solution_.trace[solution_.iterations - 1];
  iterate.rho = rho;
  iterate.z = solution_.z;
  iterate.x_N = solution_.x_N;
  iterate.delta = solution_.delta;
  iterate.w = solution_.w;
  iterate.qp = solution_.qp;
  iterate.projections = projected ? sizes_.N : 0;
  std::copy(reports_.begin(), reports_.end(), iterate.projection.begin());
  iterate.primal_residual = projected ? solution_.primal_residual[solution_.projections - 1] : 0.0;
  iterate.dual_residual = projected ? dual_residual_ : 0.0;
  iterate.complementarity_violation = complementarity_violation(lcs);
}

double Solver::complementarity_violation(Horizon lcs) noexcept {
  double worst = 0.0;
  if (sizes_.n_lambda == 0) return worst;
  for (int k = 0; k < sizes_.N; ++k) {
    const auto z_k = solution_.z.col(k);
    y_ = lcs[k].c;
    y_.noalias() += lcs[k].E * sizes_.x(z_k);
    y_.noalias() += lcs[k].F * sizes_.lambda(z_k);
    y_.noalias() += lcs[k].H * sizes_.u(z_k);
    if (!y_.allFinite()) return std::numeric_limits<double>::infinity();
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
  solution_.rho = settings_.rho;
  solution_.primal_residual.setZero();
  solution_.complementarity_violation = 0.0;
  solution_.iterations = solution_.projections = solution_.inexact_projections = 0;
  solution_.branch_nodes = 0;
  solution_.qp = {};
  solution_.projection = {};
  solution_.failed_stage = 0;
  solution_.polish = {};
  solution_.modes.setConstant(kNoMode);
}

const Solution& Solver::fail(Failure failure) noexcept {
  solution_.status = SolveStatus::kFailed;
  solution_.failure = failure;
  return solution_;
}

void shift(const Solution& solution, double rho, Start& start) {
  const Eigen::Index N = solution.delta.cols();
  start.delta.resizeLike(solution.delta);
  start.w.resizeLike(solution.w);
  for (Eigen::Index k = 0; k < N; ++k) {
    const Eigen::Index next = std::min(k + 1, N - 1);
    start.delta.col(k) = solution.delta.col(next);
    start.w.col(k) = solution.w.col(next) * (solution.rho / rho);
  }
  shift_plan(solution, 1, start);
}

void shift_plan(const Solution& solution, int stages, Start& start) {
  const Eigen::Index N = solution.modes.cols();
  start.u.resize(solution.sizes.n_u, N);
  start.modes.resizeLike(solution.modes);
  for (Eigen::Index k = 0; k < N; ++k) {
    const Eigen::Index of = std::min(k + stages, N - 1);
    start.u.col(k) = solution.sizes.u(solution.z.col(of));
    start.modes.col(k) = solution.modes.col(of);
  }
}

}  // namespace c3rt::c3
