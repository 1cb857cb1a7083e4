#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

#include "controller/c3/qp.hpp"
#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"

/// Problems of the QP step (21) and what their solution must be, found without any back end.
namespace qp_problem {

using c3rt::c3::Constraints;
using c3rt::c3::Sizes;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNone = std::numeric_limits<double>::infinity();

struct Problem {
  Sizes sizes;
  std::vector<c3rt::lcs::Lcs> lcs;  // one per stage
  c3rt::c3::Costs costs;
  std::vector<MatrixXd> W;  // one per stage
  double rho;
  VectorXd x0;
  MatrixXd x_desired, g;
  Constraints constraints = {};
  bool fixes_lambda_0 = false;
  VectorXd lambda_0 = {};
};

struct Answer {
  c3rt::c3::QpReport report;
  MatrixXd z;
  VectorXd x_N;
};

/// With W = G and g = G r.
inline void consensus(Problem& p, const MatrixXd& r) {
  p.W.clear();
  p.g.resizeLike(r);
  for (int k = 0; k < p.sizes.N; ++k) {
    p.W.push_back(p.costs.G[k]);
    p.g.col(k) = p.costs.G[k] * r.col(k);
  }
}

inline Problem ball(rolling_ball::Phase phase, double rho, double gap) {
  c3rt::support::Random random(21);
  const VectorXd x = rolling_ball::state(gap);
  const Sizes sizes = rolling_ball::sizes();
  Problem p{sizes,
            std::vector<c3rt::lcs::Lcs>(sizes.N, rolling_ball::lcs(x)),
            rolling_ball::costs(phase),
            {},
            rho,
            x,
            rolling_ball::x_desired(x),
            {}};
  MatrixXd r = random.matrix(sizes.n_z(), sizes.N);
  r.middleRows(sizes.n_x, sizes.n_lambda) *= 1000.0;  // scaled forces are of this size
  consensus(p, r);
  return p;
}

inline MatrixXd definite(c3rt::support::Random& random, int n) {
  const MatrixXd half = random.matrix(n, n);
  return half * half.transpose() + 0.1 * MatrixXd::Identity(n, n);
}

/// Everything varies over the stages: systems, Q, R and W.
inline Problem random_problem(unsigned seed) {
  c3rt::support::Random random(seed);
  const Sizes s{1 + random.index(6), 1 + random.index(6), 1 + random.index(3), 1 + random.index(8)};
  Problem p{s, {}, {}, {}, 0.3, random.vector(s.n_x), random.matrix(s.n_x, s.N + 1), {}};
  std::vector<MatrixXd> Q, R, G;
  for (int k = 0; k < s.N; ++k) {
    p.lcs.push_back({random.matrix(s.n_x, s.n_x), random.matrix(s.n_x, s.n_u),
                     random.matrix(s.n_x, s.n_lambda), random.vector(s.n_x),
                     random.matrix(s.n_lambda, s.n_x), random.matrix(s.n_lambda, s.n_lambda),
                     random.matrix(s.n_lambda, s.n_u), random.vector(s.n_lambda)});
    Q.push_back(definite(random, s.n_x));
    R.push_back(definite(random, s.n_u));
    G.push_back(definite(random, s.n_z()));
  }
  p.costs = {Q, definite(random, s.n_x), R, G, {}};
  consensus(p, random.matrix(s.n_z(), s.N));
  return p;
}

/// Adds bounds and rows of every kind that the point (z, x_N) satisfies, so that there is a
/// solution; few of them with room to spare.
inline void constrain(Problem& p, const MatrixXd& z, const VectorXd& x_N, unsigned seed) {
  c3rt::support::Random random(seed);
  const Sizes& s = p.sizes;
  const auto around = [&](const VectorXd& value, VectorXd& lower, VectorXd& upper) {
    lower.setConstant(value.size(), -kNone);
    upper.setConstant(value.size(), kNone);
    for (Eigen::Index i = 0; i < value.size(); ++i) {
      const int kind = random.index(4);
      if (kind <= 1) lower[i] = value[i] - 0.3 * random.uniform(0.0);
      if (kind >= 1 && kind <= 2) upper[i] = value[i] + 0.3 * random.uniform(0.0);
    }
  };
  Constraints& c = p.constraints;
  std::vector<VectorXd> lower(s.N), upper(s.N);
  const auto per_stage = [&](int first, int count, auto& all_lower, auto& all_upper) {
    for (int k = 0; k < s.N; ++k) around(z.col(k).segment(first, count), lower[k], upper[k]);
    all_lower = lower;
    all_upper = upper;
  };
  if (seed % 2 == 0) per_stage(0, s.n_x, c.x_min, c.x_max);
  if (seed % 3 == 0) per_stage(s.n_x, s.n_lambda, c.lambda_min, c.lambda_max);
  if (seed % 5 != 0) per_stage(s.n_x + s.n_lambda, s.n_u, c.u_min, c.u_max);
  if (seed % 4 == 0) around(x_N, c.x_N_min, c.x_N_max);
  if (seed % 3 == 1) {
    std::vector<MatrixXd> C(s.N);
    for (int k = 0; k < s.N; ++k) {
      C[k] = random.matrix(1 + random.index(2), s.n_z());
      if (random.index(3) == 0) C[k].row(0).tail(s.n_z() - s.n_x).setZero();
      around(C[k] * z.col(k), lower[k], upper[k]);
      const Eigen::Index last = C[k].rows() - 1;
      // an equality now and then
      if (k > 0 && random.index(4) == 0)
        lower[k][last] = upper[k][last] = C[k].row(last) * z.col(k);
    }
    c.C = C;
    c.C_min = lower;
    c.C_max = upper;
  }
}

inline Answer solve(c3rt::c3::QpStep& qp, const Problem& p) {
  qp.set_costs(p.costs, p.constraints);
  qp.start({p.lcs.data(), 1}, {p.W.data(), 1}, p.fixes_lambda_0 ? &p.lambda_0 : nullptr);
  Answer answer{{}, MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
  answer.report = qp.solve(p.rho, p.x0, p.x_desired, p.g, answer.z, answer.x_N);
  return answer;
}

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// One row of the constraints over all variables [z_0; …; z_{N−1}; x_N].
struct Row {
  VectorXd a;
  double lower, upper;
};

inline std::vector<Row> rows(const Problem& p) {
  const Sizes& s = p.sizes;
  const int n_x = s.n_x, n_z = s.n_z(), n = s.N * n_z + n_x;
  std::vector<Row> all;
  const auto at = [](const VectorXd& bound, Eigen::Index i, double none) {
    return bound.size() == 0 ? none : bound[i];
  };
  const auto add = [&](int offset, const VectorXd& a, double lower, double upper) {
    Row row{VectorXd::Zero(n), lower, upper};
    row.a.segment(offset, a.size()) = a;
    if (lower > -kNone || upper < kNone) all.push_back(row);
  };
  const auto bounds = [&](int offset, int count, const VectorXd& lower, const VectorXd& upper) {
    for (int i = 0; i < count; ++i) {
      add(offset + i, VectorXd::Ones(1), at(lower, i, -kNone), at(upper, i, kNone));
    }
  };
  const Constraints& c = p.constraints;
  for (int k = 0; k < s.N; ++k) {
    if (k > 0) bounds(k * n_z, n_x, c.x_min[k], c.x_max[k]);
    if (k > 0 || !p.fixes_lambda_0) {
      bounds(k * n_z + n_x, s.n_lambda, c.lambda_min[k], c.lambda_max[k]);
    }
    bounds(k * n_z + n_x + s.n_lambda, s.n_u, c.u_min[k], c.u_max[k]);
    for (Eigen::Index row = 0; row < c.C[k].rows(); ++row) {
      if (k == 0 && c.C[k].row(row).tail(n_z - n_x).isZero(0.0)) continue;
      add(k * n_z, c.C[k].row(row), at(c.C_min[k], row, -kNone), at(c.C_max[k], row, kNone));
    }
  }
  bounds(s.N * n_z, n_x, c.x_N_min, c.x_N_max);
  return all;
}

/// The solution of the whole KKT system, dense, in long double, with the rows as equalities that
/// hold with equality (to 1e-7) at a claimed answer; and how far that is from being optimal: by the
/// signs of the multipliers of those rows, where they are unique, and by the violation of the others.
struct Reference {
  MatrixXd z;
  VectorXd x_N;
  double wrong = 0.0;
  int active = 0;
};

inline Reference reference(const Problem& p, const Answer* claimed = nullptr) {
  const int n_x = p.sizes.n_x, n_z = p.sizes.n_z(), N = p.sizes.N;
  const int n = N * n_z + n_x, m = (N + 1) * n_x;
  VectorXd point = VectorXd::Zero(n);
  std::vector<Row> active;
  std::vector<int> side;  // 1 at the lower bound, −1 at the upper, 0 equality
  if (claimed != nullptr) {
    for (int k = 0; k < N; ++k) point.segment(k * n_z, n_z) = claimed->z.col(k);
    point.tail(n_x) = claimed->x_N;
    for (const Row& row : rows(p)) {
      const double value = row.a.dot(point), near = 1e-7 * std::max(1.0, std::abs(value));
      const bool lower = value <= row.lower + near, upper = value >= row.upper - near;
      if (!lower && !upper) continue;
      active.push_back(row);
      side.push_back(lower && upper ? 0 : lower ? 1 : -1);
    }
  }
  const int n_fixed = p.fixes_lambda_0 ? p.sizes.n_lambda : 0;
  const int n_active = static_cast<int>(active.size());
  const int size = n + m + n_fixed + n_active;
  LongMatrix kkt = LongMatrix::Zero(size, size);
  LongVector right = LongVector::Zero(size);
  for (int k = 0; k < N; ++k) {
    MatrixXd stage = p.rho * p.W[k];
    stage.topLeftCorner(n_x, n_x) += p.costs.Q[k];
    stage.bottomRightCorner(p.sizes.n_u, p.sizes.n_u) += p.costs.R[k];
    kkt.block(k * n_z, k * n_z, n_z, n_z) = stage.cast<long double>();
    right.segment(k * n_z, n_z) = (p.rho * p.g.col(k)).cast<long double>();
    right.segment(k * n_z, n_x) += (p.costs.Q[k] * p.x_desired.col(k)).cast<long double>();
    MatrixXd step(n_x, n_z);
    step << p.lcs[k].A, p.lcs[k].D, p.lcs[k].B;
    kkt.block(n + (k + 1) * n_x, k * n_z, n_x, n_z) = step.cast<long double>();
    right.segment(n + (k + 1) * n_x, n_x) = -p.lcs[k].d.cast<long double>();
  }
  kkt.block(N * n_z, N * n_z, n_x, n_x) = p.costs.Q_N.cast<long double>();
  right.segment(N * n_z, n_x) = (p.costs.Q_N * p.x_desired.col(N)).cast<long double>();
  for (int k = 0; k <= N; ++k) {  // −x_k of the rows above; row 0: −x_0 = −x0
    kkt.block(n + k * n_x, k * n_z, n_x, n_x) -= LongMatrix::Identity(n_x, n_x);
  }
  right.segment(n, n_x) = -p.x0.cast<long double>();
  for (int i = 0; i < n_fixed; ++i) {
    kkt(n + m + i, n_x + i) = 1.0L;
    right[n + m + i] = p.lambda_0[i];
  }
  for (int i = 0; i < n_active; ++i) {
    kkt.row(n + m + n_fixed + i).head(n) = active[i].a.transpose().cast<long double>();
    right[n + m + n_fixed + i] = side[i] == -1 ? active[i].upper : active[i].lower;
  }
  kkt.topRightCorner(n, size - n) = kkt.bottomLeftCorner(size - n, n).transpose();
  const auto factor = kkt.colPivHouseholderQr();
  const LongVector solution = factor.solve(right);
  Reference found{MatrixXd(n_z, N), solution.segment(N * n_z, n_x).cast<double>()};
  for (int k = 0; k < N; ++k) found.z.col(k) = solution.segment(k * n_z, n_z).cast<double>();
  found.active = n_active;
  const auto largest = std::max(1.0L, solution.tail(n_active).size() == 0
                                          ? 0.0L
                                          : solution.tail(n_active).cwiseAbs().maxCoeff());
  // of rows that depend on one another the multipliers are not unique
  for (int i = 0; i < n_active && factor.isInvertible(); ++i) {  // here a row's multiplier is the negative of the usual one
    const long double pull = -solution[n + m + n_fixed + i] / largest;
    found.wrong = std::max(found.wrong, static_cast<double>(-pull * side[i]));
  }
  if (claimed == nullptr) return found;
  const VectorXd at = solution.head(n).cast<double>();
  for (const Row& row : rows(p)) {
    const double value = row.a.dot(at);
    found.wrong = std::max({found.wrong, row.lower - value, value - row.upper});
  }
  return found;
}

/// Largest error beside the largest entry of each kind: states, forces and inputs differ in size.
template <typename A, typename B>
double error(const Problem& p, const A& got, const B& expected) {
  const auto relative = [](const MatrixXd& a, const MatrixXd& b) {
    if (b.size() == 0) return 0.0;
    return (a - b).cwiseAbs().maxCoeff() / std::max(1e-3, b.cwiseAbs().maxCoeff());
  };
  const int n_x = p.sizes.n_x, n_lambda = p.sizes.n_lambda, n_u = p.sizes.n_u;
  return std::max({relative(got.z.topRows(n_x), expected.z.topRows(n_x)),
                   relative(got.z.middleRows(n_x, n_lambda), expected.z.middleRows(n_x, n_lambda)),
                   relative(got.z.bottomRows(n_u), expected.z.bottomRows(n_u)),
                   relative(got.x_N, expected.x_N)});
}

}  // namespace qp_problem
