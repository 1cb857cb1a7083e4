#include "controller/miqp/monolithic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "controller/horizon/modes.hpp"
#include "controller/qp/bound.hpp"

namespace c3rt::miqp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where the variables stand: [u_k; λ_k; x_{k+1}; b_k] stage by stage.
struct Layout {
  explicit Layout(const c3::Sizes& sizes)
      : sizes_(sizes), stage_(sizes.n_u + 2 * sizes.n_lambda + sizes.n_x) {}
  int u(int k) const { return k * stage_; }
  int lambda(int k) const { return u(k) + sizes_.n_u; }
  int x(int k) const { return lambda(k - 1) + sizes_.n_lambda; }  // k ≥ 1
  int b(int k) const { return lambda(k) + sizes_.n_lambda + sizes_.n_x; }
  int size() const { return sizes_.N * stage_; }

 private:
  c3::Sizes sizes_;
  int stage_;
};

void put(Triplets& to, int row, int column, const MatrixXd& block, double factor = 1.0) {
  for (int j = 0; j < block.cols(); ++j) {
    for (int i = 0; i < block.rows(); ++i) {
      if (block(i, j) != 0.0) to.emplace_back(row + i, column + j, factor * block(i, j));
    }
  }
}

/// Rows l ≤ A x ≤ u as they come.
struct Rows {
  Triplets A;
  std::vector<double> l, u;

  int next() const { return static_cast<int>(l.size()); }
  void bound(const VectorXd& minimum, const VectorXd& maximum) {
    l.insert(l.end(), minimum.begin(), minimum.end());
    u.insert(u.end(), maximum.begin(), maximum.end());
  }
};

class Builder {
 public:
  Builder(const horizon::Problem& problem, double big_m)
      : problem_(problem), sizes_(problem.sizes), at_(problem.sizes), big_m_(big_m) {}

  Problem build() {
    const int n = at_.size();
    result_.q = VectorXd::Zero(n);
    result_.x_min = VectorXd::Constant(n, -kInfinity);
    result_.x_max = VectorXd::Constant(n, kInfinity);
    const VectorXd error = problem_.x0 - problem_.x_desired.col(0);
    result_.constant = error.dot(problem_.costs->Q[0] * error);
    for (int k = 0; k < sizes_.N; ++k) {
      add_cost(k);
      add_dynamics(k);
      add_complementarity(k);
      add_constraints(k);
    }
    result_.P.resize(n, n);
    result_.P.setFromTriplets(P_.begin(), P_.end());
    result_.A.resize(rows_.next(), n);
    result_.A.setFromTriplets(rows_.A.begin(), rows_.A.end());
    result_.l = Eigen::Map<const VectorXd>(rows_.l.data(), rows_.next());
    result_.u = Eigen::Map<const VectorXd>(rows_.u.data(), rows_.next());
    return std::move(result_);
  }

 private:
  void add_cost(int k) {
    const c3::Costs& costs = *problem_.costs;
    const MatrixXd& Q = k + 1 < sizes_.N ? costs.Q[k + 1] : costs.Q_N;
    put(P_, at_.u(k), at_.u(k), costs.R[k]);
    put(P_, at_.x(k + 1), at_.x(k + 1), Q);
    const VectorXd weighted = Q * problem_.x_desired.col(k + 1);
    result_.q.segment(at_.x(k + 1), sizes_.n_x) = -weighted;
    result_.constant += weighted.dot(problem_.x_desired.col(k + 1));
  }

  /// Puts M_x x_k into the rows from `row` on; what is known of it (k = 0) is returned instead.
  VectorXd put_x(int row, int k, const MatrixXd& M_x) {
    if (k == 0) return M_x * problem_.x0;
    put(rows_.A, row, at_.x(k), M_x);
    return VectorXd::Zero(M_x.rows());
  }

  void add_dynamics(int k) {
    const lcs::Lcs& lcs = problem_.systems[k];
    const int row = rows_.next();
    const VectorXd known = put_x(row, k, lcs.A) + lcs.d;
    put(rows_.A, row, at_.u(k), lcs.B);
    put(rows_.A, row, at_.lambda(k), lcs.D);
    put(rows_.A, row, at_.x(k + 1), -MatrixXd::Identity(sizes_.n_x, sizes_.n_x));
    rows_.bound(-known, -known);
  }

  void add_complementarity(int k) {
    const lcs::Lcs& lcs = problem_.systems[k];
    const int n = sizes_.n_lambda;
    const VectorXd none = VectorXd::Constant(n, kInfinity);
    for (const bool limit : {false, true}) {  // y ≥ 0, then y + M b ≤ M
      const int row = rows_.next();
      const VectorXd known = put_x(row, k, lcs.E) + lcs.c;
      put(rows_.A, row, at_.lambda(k), lcs.F);
      put(rows_.A, row, at_.u(k), lcs.H);
      if (limit) {
        put(rows_.A, row, at_.b(k), big_m_ * MatrixXd::Identity(n, n));
        rows_.bound(-none, VectorXd::Constant(n, big_m_) - known);
      } else {
        rows_.bound(-known, none);
      }
    }
    const int row = rows_.next();  // λ − M b ≤ 0
    put(rows_.A, row, at_.lambda(k), MatrixXd::Identity(n, n));
    put(rows_.A, row, at_.b(k), -big_m_ * MatrixXd::Identity(n, n));
    rows_.bound(-none, VectorXd::Zero(n));
    result_.x_min.segment(at_.lambda(k), n).setZero();
    result_.x_min.segment(at_.b(k), n).setZero();
    result_.x_max.segment(at_.b(k), n).setOnes();
    for (int j = 0; j < n; ++j) result_.binaries.push_back(at_.b(k) + j);
  }

  void bound(int first, const VectorXd& minimum, const VectorXd& maximum) {
    if (minimum.size() > 0) {
      auto part = result_.x_min.segment(first, minimum.size());
      part = part.cwiseMax(minimum).eval();
    }
    if (maximum.size() > 0) {
      auto part = result_.x_max.segment(first, maximum.size());
      part = part.cwiseMin(maximum).eval();
    }
  }

  void add_constraints(int k) {
    const c3::Constraints& constraints = *problem_.constraints;
    bound(at_.u(k), constraints.u_min[k], constraints.u_max[k]);
    bound(at_.lambda(k), constraints.lambda_min[k], constraints.lambda_max[k]);
    if (k > 0) bound(at_.x(k), constraints.x_min[k], constraints.x_max[k]);
    if (k + 1 == sizes_.N) bound(at_.x(sizes_.N), constraints.x_N_min, constraints.x_N_max);
    const MatrixXd& C = constraints.C[k];
    for (Index i = 0; i < C.rows(); ++i) {
      if (k == 0 && C.row(i).tail(sizes_.n_lambda + sizes_.n_u).isZero(0.0)) continue;
      const int row = rows_.next();
      const VectorXd known = put_x(row, k, C.row(i).head(sizes_.n_x));
      put(rows_.A, row, at_.lambda(k), C.row(i).segment(sizes_.n_x, sizes_.n_lambda));
      put(rows_.A, row, at_.u(k), C.row(i).tail(sizes_.n_u));
      const auto bound = [&](const VectorXd& side, double none) -> VectorXd {
        return VectorXd::Constant(1, qp::bound_at(side, i, none)) - known;
      };
      rows_.bound(bound(constraints.C_min[k], -kInfinity), bound(constraints.C_max[k], kInfinity));
    }
  }

  const horizon::Problem& problem_;
  c3::Sizes sizes_;
  Layout at_;
  double big_m_;
  Problem result_;
  Triplets P_;
  Rows rows_;
};

double largest_force_or_gap(const horizon::Problem& problem, const horizon::Plan& plan) {
  if (problem.sizes.n_lambda == 0) return 0.0;
  double largest = plan.lambda.maxCoeff();
  for (int k = 0; k < problem.sizes.N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    largest = std::max(largest, (lcs.E * plan.x.col(k) + lcs.F * plan.lambda.col(k) +
                                 lcs.H * plan.u.col(k) + lcs.c)
                                    .maxCoeff());
  }
  return largest;
}

}  // namespace

MonolithicResult solve_monolithic(const horizon::Problem& problem,
                                  const MonolithicSettings& settings) {
  if (!(settings.big_m > 0.0)) {
    throw std::invalid_argument("MonolithicSettings.big_m: expected a positive number, got " +
                                std::to_string(settings.big_m));
  }
  const c3::Sizes& sizes = problem.sizes;
  const Layout at(sizes);
  const Result found = solve(Builder(problem, settings.big_m).build(), settings.solver);
  MonolithicResult result;
  result.status = found.status;
  result.nodes = found.nodes;
  result.gap = found.gap;
  if (found.x.size() == 0) return result;

  MatrixXd lambda(sizes.n_lambda, sizes.N), u(sizes.n_u, sizes.N);
  std::vector<horizon::Side> zero;
  for (int k = 0; k < sizes.N; ++k) {
    lambda.col(k) = found.x.segment(at.lambda(k), sizes.n_lambda);
    u.col(k) = found.x.segment(at.u(k), sizes.n_u);
    for (int j = 0; j < sizes.n_lambda; ++j) {
      const bool touches = found.x[at.b(k) + j] > 0.5;
      zero.push_back(touches ? horizon::Side::kGap : horizon::Side::kForce);
    }
  }
  result.plan = horizon::roll_out(problem, lambda, u);
  if (auto exact = horizon::solve_modes(problem, zero)) {
    result.plan = std::move(*exact);
    result.is_polished = true;
  }
  // the solver's bound stays where it was; a plan well below it shows that it was none
  const double bound = found.objective - found.gap * std::max(std::abs(found.objective), 1.0);
  const double scale = std::max(std::abs(result.plan.objective), 1.0);
  result.gap = std::abs(result.plan.objective - bound) / scale;
  const double allowed = settings.solver.relative_gap + settings.solver.absolute_gap / scale;
  if (!result.is_polished || !(result.gap <= allowed)) result.status = Status::kFeasible;
  result.largest = largest_force_or_gap(problem, result.plan);
  return result;
}

}  // namespace c3rt::miqp
