#include "controller/horizon/condensed.hpp"

#include <cmath>

#include <Eigen/Cholesky>

namespace c3rt::horizon {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rows as they are found; the last ones of s.
struct Rows {
  std::vector<VectorXd> J;
  std::vector<double> c;
  std::vector<int> equalities;
  int before = 0;  // rows of s that stand ahead

  /// minimum ≤ row v + offset ≤ maximum
  void add(const VectorXd& row, double offset, double minimum, double maximum) {
    if (minimum == maximum) {
      equalities.push_back(before + static_cast<int>(J.size()));
      J.push_back(row);
      c.push_back(offset - minimum);
      return;
    }
    if (std::isfinite(minimum)) {
      J.push_back(row);
      c.push_back(offset - minimum);
    }
    if (std::isfinite(maximum)) {
      J.push_back(-row);
      c.push_back(maximum - offset);
    }
  }

  /// The same for several rows; an empty bound is none.
  void add(const MatrixXd& rows, const VectorXd& offset, const VectorXd& minimum,
           const VectorXd& maximum) {
    for (Index i = 0; i < rows.rows(); ++i) {
      add(rows.row(i), offset[i], minimum.size() == 0 ? -INFINITY : minimum[i],
          maximum.size() == 0 ? INFINITY : maximum[i]);
    }
  }
};

}  // namespace

Condensed condense(const Problem& problem) {
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const int n_stage = n_u + n_lambda, n_v = N * n_stage;
  const c3::Costs& costs = *problem.costs;
  const c3::Constraints& constraints = *problem.constraints;
  Condensed result;
  result.n_pairs = N * n_lambda;
  result.H = MatrixXd::Zero(n_v, n_v);
  result.g = VectorXd::Zero(n_v);
  MatrixXd pairs = MatrixXd::Zero(2 * result.n_pairs, n_v);
  VectorXd offsets = VectorXd::Zero(2 * result.n_pairs);
  Rows rows;
  rows.before = 2 * result.n_pairs;

  MatrixXd X = MatrixXd::Zero(n_x, n_v);  // x_k = X v + x
  VectorXd x = problem.x0;
  const auto add_cost = [&](const MatrixXd& Q, int k) {
    const VectorXd error = x - problem.x_desired.col(k);
    const auto past = X.leftCols(k * n_stage);
    const MatrixXd weighted = Q * past;
    result.H.topLeftCorner(past.cols(), past.cols()).noalias() += past.transpose() * weighted;
    result.g.head(past.cols()).noalias() += weighted.transpose() * error;
    result.constant += error.dot(Q * error);
  };

  MatrixXd Z = MatrixXd::Zero(problem.sizes.n_z(), n_v);  // z_k = Z v + [x; 0; 0]
  VectorXd z = VectorXd::Zero(problem.sizes.n_z());
  for (int k = 0; k < N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    const int u = k * n_stage, lambda = u + n_u;
    add_cost(costs.Q[k], k);
    result.H.block(u, u, n_u, n_u) += costs.R[k];

    Z.setZero();
    Z.topRows(n_x) = X;
    Z.block(n_x, lambda, n_lambda, n_lambda).setIdentity();
    Z.block(n_x + n_lambda, u, n_u, n_u).setIdentity();
    z.head(n_x) = x;
    pairs.block(k * n_lambda, lambda, n_lambda, n_lambda).setIdentity();
    auto gap = pairs.middleRows(result.n_pairs + k * n_lambda, n_lambda);
    gap.noalias() = lcs.E * X;
    gap.middleCols(lambda, n_lambda) += lcs.F;
    gap.middleCols(u, n_u) += lcs.H;
    offsets.segment(result.n_pairs + k * n_lambda, n_lambda) = lcs.E * x + lcs.c;

    if (k > 0) rows.add(X, x, constraints.x_min[k], constraints.x_max[k]);
    rows.add(Z.middleRows(n_x, n_lambda), VectorXd::Zero(n_lambda), constraints.lambda_min[k],
             constraints.lambda_max[k]);
    rows.add(Z.bottomRows(n_u), VectorXd::Zero(n_u), constraints.u_min[k], constraints.u_max[k]);
    const MatrixXd& C = constraints.C[k];
    for (Index i = 0; i < C.rows(); ++i) {
      if (k == 0 && C.row(i).tail(n_lambda + n_u).isZero(0.0)) continue;
      rows.add(Z.transpose() * C.row(i).transpose(), C.row(i).dot(z), constraints.C_min[k][i],
               constraints.C_max[k][i]);
    }

    x = lcs.A * x + lcs.d;
    X = lcs.A * X;
    X.middleCols(u, n_u) += lcs.B;
    X.middleCols(lambda, n_lambda) += lcs.D;
  }
  add_cost(costs.Q_N, N);
  rows.add(X, x, constraints.x_N_min, constraints.x_N_max);

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

Plan roll_out(const Problem& problem, const VectorXd& v) {
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const Eigen::Map<const MatrixXd> stages(v.data(), n_u + n_lambda, N);
  return roll_out(problem, MatrixXd(stages.bottomRows(n_lambda)), MatrixXd(stages.topRows(n_u)));
}

LeastDistance::LeastDistance(const Condensed& condensed, double epsilon)
    : condensed_(&condensed),
      epsilon_(epsilon * std::max(condensed.H.diagonal().maxCoeff(), 1e-300)) {
  MatrixXd definite = condensed.H;
  definite.diagonal().array() += epsilon_;
  L_ = definite.llt().matrixL();
  C_ = L_.triangularView<Eigen::Lower>().solve(condensed.J.transpose());
  scale_.resize(C_.cols());
  for (Index i = 0; i < C_.cols(); ++i) {
    const double length = C_.col(i).norm();
    scale_[i] = length > 0.0 ? 1.0 / length : 1.0;
    C_.col(i) *= scale_[i];
  }
}

void LeastDistance::centre(const VectorXd& v_c) {
  const VectorXd slope = condensed_->g - epsilon_ * v_c;
  const VectorXd half = L_.triangularView<Eigen::Lower>().solve(slope);
  v_free_ = -L_.triangularView<Eigen::Lower>().transpose().solve(half);
  lowest_ = condensed_->constant + epsilon_ * v_c.squaredNorm() - half.squaredNorm();
  t_ = scale_.cwiseProduct(condensed_->J * v_free_ + condensed_->c);
}

VectorXd LeastDistance::v(const VectorXd& f) const {
  return v_free_ + L_.triangularView<Eigen::Lower>().transpose().solve(f);
}

}  // namespace c3rt::horizon
