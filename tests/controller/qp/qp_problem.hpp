#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "controller/qp/qp.hpp"
#include "tests/support/random.hpp"
#include "tests/support/rolling_ball.hpp"

/// Problems of the QP step (21) and what their solution must be, found without any back end.
namespace qp_problem {

using c3rt::qp::Constraints;
using c3rt::qp::Sizes;
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
  c3rt::qp::QpReport report;
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

inline Answer solve(c3rt::qp::QpStep& qp, const Problem& p) {
  qp.set_costs(p.costs, p.constraints);
  qp.start({p.lcs.data(), 1}, {p.W.data(), 1}, p.fixes_lambda_0 ? &p.lambda_0 : nullptr);
  Answer answer{{}, MatrixXd(p.sizes.n_z(), p.sizes.N), VectorXd(p.sizes.n_x)};
  answer.report = qp.solve(p.rho, p.x0, p.x_desired, p.g, answer.z, answer.x_N);
  return answer;
}

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

// four times the digits of double: where weights and modes lie 1e10 apart, the dense KKT system in
// long double is off by 1e-5
#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 Quad;
#else
using Quad = long double;
#endif
using QuadMatrix = std::vector<std::vector<Quad>>;

inline double near_of(double value) { return 1e-7 * std::max(1.0, std::abs(value)); }

inline Quad size_of(Quad value) { return value < 0 ? -value : value; }

/// Gaussian elimination of [M right] with partial pivoting, M square with nothing farther than
/// `band` from its diagonal.
inline void eliminate(QuadMatrix& M, int band) {
  const int n = static_cast<int>(M.size());
  for (int c = 0; c < n; ++c) {
    const int below = std::min(n, c + band + 1), right = std::min(n, c + 2 * band + 1);
    int pivot = c;
    for (int r = c + 1; r < below; ++r) {
      if (size_of(M[r][c]) > size_of(M[pivot][c])) pivot = r;
    }
    std::swap(M[c], M[pivot]);
    const int all = static_cast<int>(M[c].size());
    for (int r = c + 1; r < below; ++r) {
      if (M[r][c] == 0) continue;
      const Quad factor = M[r][c] / M[c][c];
      for (int j = c; j < right; ++j) M[r][j] -= factor * M[c][j];
      for (int j = n; j < all; ++j) M[r][j] -= factor * M[c][j];
    }
  }
  for (int c = n - 1; c >= 0; --c) {
    const int right = std::min(n, c + 2 * band + 1), all = static_cast<int>(M[c].size());
    for (int s = n; s < all; ++s) {
      Quad value = M[c][s];
      for (int j = c + 1; j < right; ++j) value -= M[c][j] * M[j][s];
      M[c][s] = value / M[c][c];
    }
  }
}

/// x and the rank of S x = b, S symmetric and positive semidefinite, with full pivoting; what
/// depends on other rows, but for what is below rounding of its unit, gets 0.
inline int solve_semidefinite(QuadMatrix S, std::vector<Quad> b, const std::vector<Quad>& unit,
                              std::vector<Quad>& x) {
  const int n = static_cast<int>(S.size());
  std::vector<int> order(n);
  for (int i = 0; i < n; ++i) order[i] = i;
  int rank = 0;
  for (; rank < n; ++rank) {
    int pivot = rank;
    const auto left = [&](int i) { return S[order[i]][order[i]] / unit[order[i]]; };
    for (int i = rank + 1; i < n; ++i) {
      if (left(i) > left(pivot)) pivot = i;
    }
    if (!(left(pivot) > Quad(1e-22))) break;
    std::swap(order[rank], order[pivot]);
    const int p = order[rank];
    for (int i = rank + 1; i < n; ++i) {
      const int r = order[i];
      const Quad factor = S[r][p] / S[p][p];
      for (int j = rank; j < n; ++j) S[r][order[j]] -= factor * S[p][order[j]];
      b[r] -= factor * b[p];
    }
  }
  x.assign(n, Quad(0));
  for (int i = rank - 1; i >= 0; --i) {
    Quad value = b[order[i]];
    for (int j = i + 1; j < rank; ++j) value -= S[order[i]][order[j]] * x[order[j]];
    x[order[i]] = value / S[order[i]][order[i]];
  }
  return rank;
}

/// The solution of the whole KKT system, in quadruple precision, with the rows as equalities that
/// hold with equality (to 1e-7) at a claimed answer; and how far that is from being optimal: by the
/// signs of the multipliers of those rows, where they are unique, and by the violation of the
/// others.
struct Reference {
  MatrixXd z;
  VectorXd x_N;
  double wrong = 0.0;
  int active = 0;
  int wrong_row = -1;  // of rows(p), whose multiplier's sign is wrong the most; −1: none
};

/// @param active_rows by rows(p)
inline Reference reference_with(const Problem& p, const Answer* claimed,
                                const std::vector<bool>& active_rows) {
  const int n_x = p.sizes.n_x, n_z = p.sizes.n_z(), N = p.sizes.N, n_nu = n_z - n_x;
  const int n = N * n_z + n_x;
  std::vector<Row> active;
  std::vector<int> side;  // 1 at the lower bound, −1 at the upper, 0 equality
  const int n_fixed = p.fixes_lambda_0 ? p.sizes.n_lambda : 0;
  for (int i = 0; i < n_fixed; ++i) {
    active.push_back({VectorXd::Unit(n, n_x + i), p.lambda_0[i], p.lambda_0[i]});
    side.push_back(0);
  }
  const std::vector<Row> all = rows(p);
  std::vector<int> number(n_fixed, -1);  // of each active row
  if (claimed != nullptr) {
    VectorXd point(n);
    point << claimed->z.reshaped(), claimed->x_N;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!active_rows[i]) continue;
      const Row& row = all[i];
      const double value = row.a.dot(point), near = near_of(value);
      const bool lower = value <= row.lower + near, upper = value >= row.upper - near;
      active.push_back(row);
      side.push_back(lower && upper ? 0 : lower ? 1 : -1);
      number.push_back(static_cast<int>(i));
    }
  }
  const int n_active = static_cast<int>(active.size());

  // stage by stage x_k, ν_k and the multipliers of x_k = …; a last x_N and its multipliers
  const int block = n_z + n_x, size = N * block + 2 * n_x;
  const auto x_at = [&](int k) { return k * block; };
  const auto multiplier_at = [&](int k) { return k * block + n_x; };
  const auto nu_at = [&](int k) { return k * block + 2 * n_x; };
  const auto place = [&](int i) {  // of entry i of [z_0; …; x_N]
    const int k = i / n_z, j = i % n_z;
    return j < n_x ? x_at(k) + j : nu_at(k) + j - n_x;
  };
  QuadMatrix M(size, std::vector<Quad>(size + 1 + n_active, Quad(0)));
  for (int k = 0; k <= N; ++k) {
    MatrixXd stage = p.costs.Q_N;
    VectorXd linear = p.costs.Q_N * p.x_desired.col(N);
    if (k < N) {
      stage = p.rho * p.W[k];
      stage.topLeftCorner(n_x, n_x) += p.costs.Q[k];
      stage.bottomRightCorner(p.sizes.n_u, p.sizes.n_u) += p.costs.R[k];
      linear = p.rho * p.g.col(k);
      linear.head(n_x) += p.costs.Q[k] * p.x_desired.col(k);
    }
    for (int i = 0; i < stage.rows(); ++i) {
      const int row = place(k * n_z + i);
      M[row][size] = linear[i];
      for (int j = 0; j < stage.cols(); ++j) M[row][place(k * n_z + j)] = stage(i, j);
    }
    const auto couple = [&](int multiplier, int entry, double value) {
      M[multiplier_at(k) + multiplier][entry] = value;
      M[entry][multiplier_at(k) + multiplier] = value;
    };
    for (int i = 0; i < n_x; ++i) {
      couple(i, x_at(k) + i, -1.0);
      M[multiplier_at(k) + i][size] = k == 0 ? -p.x0[i] : -p.lcs[k - 1].d[i];
      if (k == 0) continue;
      const auto& lcs = p.lcs[k - 1];
      for (int j = 0; j < n_x; ++j) couple(i, x_at(k - 1) + j, lcs.A(i, j));
      for (int j = 0; j < n_nu; ++j) {
        couple(i, nu_at(k - 1) + j,
               j < p.sizes.n_lambda ? lcs.D(i, j) : lcs.B(i, j - p.sizes.n_lambda));
      }
    }
  }
  for (int i = 0; i < n_active; ++i) {
    for (int j = 0; j < n; ++j) M[place(j)][size + 1 + i] = active[i].a[j];
  }
  eliminate(M, 2 * block);
  // how the rows move for a unit force of each
  QuadMatrix S(n_active, std::vector<Quad>(n_active, Quad(0)));
  std::vector<Quad> missing(n_active), unit(n_active, Quad(0)), force;
  for (int i = 0; i < n_active; ++i) {
    for (int j = 0; j < size; ++j) unit[i] = std::max(unit[i], size_of(M[j][size + 1 + i]));
    unit[i] *= Quad(1e-8);  // an input that moves the row has moved it by more
    missing[i] = side[i] == -1 ? active[i].upper : active[i].lower;
    for (int j = 0; j < n; ++j) {
      if (active[i].a[j] == 0.0) continue;
      missing[i] -= active[i].a[j] * M[place(j)][size];
      for (int other = 0; other < n_active; ++other) {
        S[i][other] += active[i].a[j] * M[place(j)][size + 1 + other];
      }
    }
  }
  for (int i = 0; i < n_active; ++i) unit[i] = std::max(unit[i], S[i][i]);
  const int rank = solve_semidefinite(S, missing, unit, force);

  VectorXd at(n);
  for (int j = 0; j < n; ++j) {
    Quad value = M[place(j)][size];
    for (int i = 0; i < n_active; ++i) value += force[i] * M[place(j)][size + 1 + i];
    at[j] = static_cast<double>(value);
  }
  Reference found{at.head(N * n_z).reshaped(n_z, N), at.tail(n_x)};
  found.active = n_active - n_fixed;
  Quad largest = 1;
  for (const Quad& one : force) largest = std::max(largest, size_of(one));
  // of rows that depend on one another the multipliers are not unique
  for (int i = 0; i < n_active && rank == n_active; ++i) {
    const double wrong = static_cast<double>(-force[i] * side[i] / largest);
    if (wrong <= found.wrong) continue;
    found.wrong = wrong;
    found.wrong_row = number[i];
  }
  if (claimed == nullptr) return found;
  for (const Row& row : all) {
    const double value = row.a.dot(at);
    found.wrong = std::max({found.wrong, row.lower - value, value - row.upper});
  }
  return found;
}

/// A row that is as near to its bound as `near_of` need not be active where the problem is as
/// sensitive as that: rows whose multipliers have the wrong sign are left out, one by one. What the
/// answer is checked by, KKT, holds for the optimum alone, whichever rows were tried.
inline Reference reference(const Problem& p, const Answer* claimed = nullptr) {
  const std::vector<Row> all = rows(p);
  std::vector<bool> active(all.size(), false);
  if (claimed != nullptr) {
    VectorXd point(p.sizes.N * p.sizes.n_z() + p.sizes.n_x);
    point << claimed->z.reshaped(), claimed->x_N;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double value = all[i].a.dot(point), near = near_of(value);
      active[i] = value <= all[i].lower + near || value >= all[i].upper - near;
    }
  }
  const Reference first = reference_with(p, claimed, active);
  Reference found = first;
  for (std::size_t turn = 0; turn < all.size() && found.wrong_row >= 0; ++turn) {
    if (found.wrong < 1e-12) break;
    active[static_cast<std::size_t>(found.wrong_row)] = false;
    found = reference_with(p, claimed, active);
  }
  return found.wrong < first.wrong ? found : first;
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
