#include "controller/horizon/condensed.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "controller/qp/bound.hpp"

namespace c3rt::horizon {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRounding = 1e-14;  // of the terms of a bound
constexpr int kRepeats = 12;         // centres that a bound may take
constexpr double kDear = 1e6;        // of the cost: a bound above is as good as infeasible
constexpr double kNothing = 1e-12;   // of its terms: rounding of a row that nothing changes

/// Units of v in which H has a unit diagonal. A force without any cost gets the unit in which it
/// counts in its gaps as much as what has a cost does at most.
VectorXd units(const Condensed& condensed) {
  const Index n = condensed.H.rows();
  VectorXd unit = VectorXd::Ones(n);
  VectorXd costly = VectorXd::Zero(n);
  for (Index j = 0; j < n; ++j) {
    if (condensed.H(j, j) > 0.0) costly[j] = unit[j] = 1.0 / std::sqrt(condensed.H(j, j));
  }
  const MatrixXd gaps = condensed.J.middleRows(condensed.n_pairs, condensed.n_pairs);
  const VectorXd weight = (gaps * costly.asDiagonal()).rowwise().norm();
  for (Index j = 0; j < n; ++j) {
    if (costly[j] > 0.0) continue;
    double counts = 0.0;
    for (Index i = 0; i < gaps.rows(); ++i) {
      if (weight[i] > 0.0) counts = std::max(counts, std::abs(gaps(i, j)) / weight[i]);
    }
    if (counts > 0.0) unit[j] = 1.0 / counts;
  }
  return unit;
}

/// Into its bounds; an empty bound is none.
VectorXd clamped(VectorXd value, const VectorXd& minimum, const VectorXd& maximum) {
  if (minimum.size() > 0) value = value.cwiseMax(minimum);
  if (maximum.size() > 0) value = value.cwiseMin(maximum);
  return value;
}

/// The sum of terms of this size, of which nothing is left but rounding.
double without_rounding(double sum, double terms) {
  return std::abs(sum) <= kNothing * terms ? 0.0 : sum;
}

/// Rows as they are found; the last ones of s.
struct Rows {
  std::vector<VectorXd> J;
  std::vector<double> c;
  std::vector<int> equalities;
  int before = 0;  // rows of s that stand ahead

  /// minimum ≤ row v + offset ≤ maximum
  /// @param terms  what the offset adds up
  void add(const VectorXd& row, double offset, double terms, double minimum, double maximum) {
    const bool constant = row.isZero(0.0);
    const auto beside = [&](double bound) {
      const double difference = offset - bound;
      return constant ? without_rounding(difference, terms + std::abs(bound)) : difference;
    };
    if (minimum == maximum) {
      equalities.push_back(before + static_cast<int>(J.size()));
      J.push_back(row);
      c.push_back(beside(minimum));
      return;
    }
    if (std::isfinite(minimum)) {
      J.push_back(row);
      c.push_back(beside(minimum));
    }
    if (std::isfinite(maximum)) {
      J.emplace_back(-row);
      c.push_back(-beside(maximum));
    }
  }

  /// The same for several rows; an empty bound is none.
  void add(const MatrixXd& rows, const VectorXd& offset, const VectorXd& terms,
           const VectorXd& minimum, const VectorXd& maximum) {
    for (Index i = 0; i < rows.rows(); ++i) {
      add(rows.row(i), offset[i], terms[i], qp::bound_at(minimum, i, -INFINITY),
          qp::bound_at(maximum, i, INFINITY));
    }
  }
};

}  // namespace

Condensed condense(const Problem& problem, const std::vector<Side>& zero) {
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const int n_stage = n_u + n_lambda, n_v = N * n_stage;
  const c3::Costs& costs = *problem.costs;
  const c3::Constraints& constraints = *problem.constraints;
  Condensed result;
  result.n_pairs = N * n_lambda;
  result.H = MatrixXd::Zero(n_v, n_v);
  result.g = VectorXd::Zero(n_v);
  result.K = stabilising_feedback(problem, zero);
  MatrixXd pairs = MatrixXd::Zero(2 * result.n_pairs, n_v);
  VectorXd offsets = VectorXd::Zero(2 * result.n_pairs);
  Rows rows;
  rows.before = 2 * result.n_pairs;

  // z_k = Z v + z, and x_k and [u_k; λ_k] in the same way
  MatrixXd X = MatrixXd::Zero(n_x, n_v), U(n_stage, n_v), Z(problem.sizes.n_z(), n_v);
  VectorXd x = problem.x0, u(n_stage), z(problem.sizes.n_z());
  VectorXd x_terms = x.cwiseAbs();  // what x adds up
  // the error's part that v brings is zero behind `columns`
  const auto add_cost = [&result](const MatrixXd& weight, const MatrixXd& matrix,
                                  const VectorXd& error, Index columns) {
    const auto past = matrix.leftCols(columns);
    const MatrixXd weighted = weight * past;
    result.H.topLeftCorner(columns, columns).noalias() += past.transpose() * weighted;
    result.g.head(columns).noalias() += weighted.transpose() * error;
    result.constant += error.dot(weight * error);
  };

  for (int k = 0; k < N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    const int here = k * n_stage, past = here + n_stage;
    U.noalias() = result.K[k] * X;
    U.middleCols(here, n_stage).setIdentity();
    u.noalias() = result.K[k] * x;
    const auto inputs = U.topRows(n_u), forces = U.bottomRows(n_lambda);
    const auto input = u.head(n_u), force = u.tail(n_lambda);
    add_cost(costs.Q[k], X, x - problem.x_desired.col(k), here);
    add_cost(costs.R[k], inputs, input, past);

    Z << X, forces, inputs;
    z << x, force, input;
    pairs.middleRows(k * n_lambda, n_lambda) = forces;
    offsets.segment(k * n_lambda, n_lambda) = force;
    const int gaps = result.n_pairs + k * n_lambda;
    auto gap = pairs.middleRows(gaps, n_lambda);
    gap.noalias() = lcs.E * X;
    gap.noalias() += lcs.F * forces;
    gap.noalias() += lcs.H * inputs;
    offsets.segment(gaps, n_lambda) = lcs.E * x + lcs.F * force + lcs.H * input + lcs.c;
    const VectorXd gap_terms = lcs.E.cwiseAbs() * x_terms + lcs.F.cwiseAbs() * force.cwiseAbs() +
                               lcs.H.cwiseAbs() * input.cwiseAbs() + lcs.c.cwiseAbs();
    for (int j = 0; j < n_lambda; ++j) {
      if (gap.row(j).isZero(0.0))
        offsets[gaps + j] = without_rounding(offsets[gaps + j], gap_terms[j]);
    }

    if (k > 0) rows.add(X, x, x_terms, constraints.x_min[k], constraints.x_max[k]);
    rows.add(forces, force, force.cwiseAbs(), constraints.lambda_min[k], constraints.lambda_max[k]);
    rows.add(inputs, input, input.cwiseAbs(), constraints.u_min[k], constraints.u_max[k]);
    const MatrixXd& C = constraints.C[k];
    for (Index i = 0; i < C.rows(); ++i) {
      if (k == 0 && C.row(i).tail(n_lambda + n_u).isZero(0.0)) continue;
      rows.add(Z.transpose() * C.row(i).transpose(), C.row(i).dot(z),
               C.row(i).cwiseAbs().dot(z.cwiseAbs()),
               qp::bound_at(constraints.C_min[k], i, -INFINITY),
               qp::bound_at(constraints.C_max[k], i, INFINITY));
    }

    x_terms = lcs.A.cwiseAbs() * x_terms + lcs.B.cwiseAbs() * input.cwiseAbs() +
              lcs.D.cwiseAbs() * force.cwiseAbs() + lcs.d.cwiseAbs();
    x = (lcs.A * x + lcs.B * input + lcs.D * force + lcs.d).eval();
    X = (lcs.A * X).eval();
    X.noalias() += lcs.B * inputs;
    X.noalias() += lcs.D * forces;
  }
  add_cost(costs.Q_N, X, x - problem.x_desired.col(N), n_v);
  rows.add(X, x, x_terms, constraints.x_N_min, constraints.x_N_max);

  const Index n_rows = rows.before + static_cast<Index>(rows.J.size());
  result.J.resize(n_rows, n_v);
  result.c.resize(n_rows);
  result.J.topRows(rows.before) = pairs;
  result.c.head(rows.before) = offsets;
  for (std::size_t i = 0; i < rows.J.size(); ++i) {
    result.J.row(rows.before + i) = rows.J[i].transpose();
    result.c[rows.before + i] = rows.c[i];
  }
  result.equalities = rows.equalities;
  return result;
}

Plan roll_out(const Problem& problem, const Condensed& condensed, const VectorXd& v,
              const std::vector<Side>& zero) {
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const int n_stage = n_u + n_lambda;
  Plan plan{MatrixXd(n_x, N + 1), MatrixXd(n_lambda, N), MatrixXd(n_u, N)};
  plan.x.col(0) = problem.x0;
  for (int k = 0; k < N; ++k) {
    const VectorXd inputs = v.segment(k * n_stage, n_stage) + condensed.K[k] * plan.x.col(k);
    const c3::Constraints& constraints = *problem.constraints;
    plan.u.col(k) = clamped(inputs.head(n_u), constraints.u_min[k], constraints.u_max[k]);
    plan.lambda.col(k) =
        clamped(inputs.tail(n_lambda), constraints.lambda_min[k], constraints.lambda_max[k]);
    for (int j = 0; j < n_lambda; ++j) {
      double& force = plan.lambda(j, k);
      force = zero[k * n_lambda + j] == Side::kForce ? 0.0 : std::max(force, 0.0);
    }
    plan.x.col(k + 1) = next_state(problem, plan, k);
  }
  evaluate(problem, plan);
  return plan;
}

VectorXd inputs_of(const Problem& problem, const Condensed& condensed, const Plan& plan) {
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const int n_stage = n_u + n_lambda;
  VectorXd v(N * n_stage);
  for (int k = 0; k < N; ++k) {
    v.segment(k * n_stage, n_stage) << plan.u.col(k), plan.lambda.col(k);
    v.segment(k * n_stage, n_stage) -= condensed.K[k] * plan.x.col(k);
  }
  return v;
}

LeastDistance::LeastDistance(const Condensed& condensed, double epsilon)
    : condensed_(&condensed), epsilon_(epsilon), unit_(units(condensed)) {
  g_ = condensed.g.cwiseProduct(unit_);
  MatrixXd definite = unit_.asDiagonal() * condensed.H * unit_.asDiagonal();
  definite.diagonal().array() += epsilon_;
  L_ = definite.llt().matrixL();
  C_ = unit_.asDiagonal() * condensed.J.transpose();
  L_.triangularView<Eigen::Lower>().solveInPlace(C_);
  scale_.resize(C_.cols());
  double largest = 0.0;
  for (Index i = 0; i < C_.cols(); ++i) {
    const double length = C_.col(i).norm();
    scale_[i] = length > 0.0 ? 1.0 / length : 0.0;
    C_.col(i) *= scale_[i];
    largest = std::max(largest, std::abs(scale_[i] * condensed.c[i]));
  }
  // rows that nothing changes are below, at or above zero, no matter by how much
  if (largest == 0.0) largest = 1.0;
  for (Index i = 0; i < C_.cols(); ++i) {
    if (scale_[i] == 0.0)
      scale_[i] = condensed.c[i] == 0.0 ? 1.0 : largest / std::abs(condensed.c[i]);
  }
}

void LeastDistance::place(const VectorXd& v, Centre& centre) const {
  centre.v = v;
  centre.half = g_ - epsilon_ * v;
  L_.triangularView<Eigen::Lower>().solveInPlace(centre.half);
  centre.lowest = condensed_->constant + epsilon_ * v.squaredNorm() - centre.half.squaredNorm();
  centre.t = scale_.cwiseProduct(condensed_->c);
  centre.t.noalias() -= C_.transpose() * centre.half;
}

VectorXd LeastDistance::normalised(const Centre& centre, const VectorXd& f) const {
  return L_.triangularView<Eigen::Lower>().transpose().solve(f - centre.half);
}

void LeastDistance::meet(const qp::NodeQp& qp, VectorXd& v) const {
  VectorXd s(qp.n_active());
  for (int repeat = 0; repeat < 3; ++repeat) {
    const VectorXd unscaled = original(v);
    for (int i = 0; i < qp.n_active(); ++i) {
      const int row = qp.active(i);
      s[i] = scale_[row] * (condensed_->J.row(row).dot(unscaled) + condensed_->c[row]);
    }
    v += L_.triangularView<Eigen::Lower>().transpose().solve(qp.against(s));
  }
}

double LeastDistance::reach(const VectorXd& v) const {
  return kReach * (v.norm() + std::sqrt(std::max(0.0, condensed_->constant)));
}

LeastDistance::Bound LeastDistance::dual(const VectorXd& v_c, const std::vector<int>& rows,
                                         const Multipliers& multipliers) const {
  const auto L = L_.triangularView<Eigen::Lower>();
  VectorXd half = g_ - epsilon_ * v_c;
  L.solveInPlace(half);
  VectorXd t(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    t[i] = scale_[rows[i]] * condensed_->c[rows[i]] - C_.col(rows[i]).dot(half);
  }
  const VectorXd mu = multipliers(t);
  VectorXd f = VectorXd::Zero(v_c.size());
  for (std::size_t i = 0; i < rows.size(); ++i) f += mu[i] * C_.col(rows[i]);
  Bound bound{0.0, 0.0, L.transpose().solve(f - half)};
  const double moved = (bound.v - v_c).norm();
  bound.curvature_loss = epsilon_ * moved * (moved + 2.0 * reach(bound.v));
  const double rounding =
      kRounding * (condensed_->constant + half.squaredNorm() + f.squaredNorm() +
                   bound.v.squaredNorm() + 2.0 * t.cwiseAbs().dot(mu.cwiseAbs()));
  bound.value = condensed_->constant + epsilon_ * v_c.squaredNorm() - half.squaredNorm() -
                f.squaredNorm() - 2.0 * t.dot(mu) - bound.curvature_loss - rounding;
  if (bound.curvature_loss <= rounding) bound.curvature_loss = 0.0;
  return bound;
}

LeastDistance::Bound LeastDistance::best_bound(VectorXd v_c, const std::vector<int>& rows,
                                               const Multipliers& multipliers,
                                               double enough) const {
  Bound best{-std::numeric_limits<double>::infinity(), 0.0, v_c};
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    Bound bound = dual(v_c, rows, multipliers);
    v_c = bound.v;
    const bool converged = bound.curvature_loss == 0.0;
    if (bound.value > best.value) best = std::move(bound);
    if (best.value >= enough || converged) break;
  }
  return best;
}

LeastDistance::Bound LeastDistance::lower_bound(const Centre& centre, const qp::NodeQp& qp,
                                                double enough) const {
  std::vector<int> rows;
  for (int i = 0; i < qp.n_active(); ++i) rows.push_back(qp.active(i));
  const auto multipliers = [&](VectorXd t) {
    qp.multipliers(t);
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (!qp.is_pinned(rows[i])) t[i] = std::max(t[i], 0.0);
    return t;
  };
  return best_bound(normalised(centre, qp.f()), rows, multipliers, enough);
}

double LeastDistance::infeasible_below(const Centre& centre, const qp::NodeQp& qp,
                                       double enough) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const qp::NodeQp::Contradiction against = qp.contradiction();
  const double slope = (L_.triangularView<Eigen::Lower>() * against.normal).norm();
  if (against.violation > (slope + kRounding * against.weight) * reach(normalised(centre, qp.f())))
    return kInfinity;

  // the combination as multipliers: in proportion to it the dual function rises from the free
  // minimum, until the square of its normal counts
  const Bound free = best_bound(
      normalised(centre, VectorXd::Zero(qp.f().size())), {}, [](const VectorXd& t) { return t; },
      kInfinity);
  std::vector<int> rows;
  for (int i = 0; i < qp.n_active(); ++i) rows.push_back(qp.active(i));
  rows.push_back(against.constraint);
  VectorXd combination(rows.size());
  combination << -against.sign * against.coefficients, against.sign;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (!qp.is_pinned(rows[i])) combination[i] = std::max(combination[i], 0.0);
  const double dear = enough < kInfinity ? enough : kDear * condensed_->constant;
  const double wanted = 2.0 * std::max(dear - free.value, 0.0);
  const double curvature = against.normal.squaredNorm();
  const double within = against.violation * against.violation - curvature * wanted;
  // the smaller root of 2 τ violation − τ² curvature = wanted, or the top
  const double factor = within > 0.0 ? wanted / (against.violation + std::sqrt(within))
                                     : against.violation / curvature;
  const Bound bound =
      dual(free.v, rows, [&](const VectorXd&) { return VectorXd(factor * combination); });
  return std::max(free.value, bound.value);
}

}  // namespace c3rt::horizon
