#include "controller/horizon/modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>

#include "controller/c3/node_qp.hpp"

namespace c3rt::horizon {
namespace {

constexpr double kEpsilon = 1e-8;     // of the largest curvature, where the cost has none
constexpr double kTolerance = 1e-12;  // of the largest normalised |s| at the free minimiser
constexpr double kSameObjective = 1e-12;
constexpr int kMaxCentres = 30;

/// Where λ_kj stands in v.
int index_of_force(const c3::Sizes& sizes, int pair) {
  const int k = pair / sizes.n_lambda, j = pair % sizes.n_lambda;
  return k * (sizes.n_u + sizes.n_lambda) + sizes.n_u + j;
}

/// Moves v the least distance that brings the rows with s = 0 to zero, which the condition number
/// of the regularised cost has left at some 1e-7.
void meet(const Condensed& condensed, const Eigen::VectorXd& s, double tolerance,
          Eigen::VectorXd& v) {
  std::vector<int> rows;
  for (int i = 0; i < s.size(); ++i) {
    if (s[i] <= tolerance) rows.push_back(i);
  }
  Eigen::MatrixXd J(rows.size(), v.size());
  Eigen::VectorXd c(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    J.row(i) = condensed.J.row(rows[i]);
    c[i] = condensed.c[rows[i]];
  }
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(J);
  for (int i = 0; i < 2; ++i) v -= decomposition.solve(J * v + c);
}

}  // namespace

std::optional<Plan> solve_modes(const Problem& problem, const Condensed& condensed,
                                const std::vector<Side>& zero) {
  LeastDistance least(condensed, kEpsilon);
  c3::NodeQp qp(condensed.H.rows(), condensed.J.rows());
  Eigen::VectorXd v = Eigen::VectorXd::Zero(condensed.g.size());
  // λ has no cost of its own: the regularised QP is solved around its last minimiser, until that
  // changes nothing (proximal point method)
  std::optional<Plan> best;
  for (int i = 0; i < kMaxCentres; ++i) {
    least.centre(v);
    qp.start(least.t());
    for (const int row : condensed.equalities) qp.pin(row);
    for (int pair = 0; pair < condensed.n_pairs; ++pair) {
      qp.pin(zero[pair] == Side::kForce ? pair : condensed.n_pairs + pair);
    }
    const double tolerance = kTolerance * least.t().cwiseAbs().maxCoeff();
    const auto status =
        qp.solve(least.C(), least.t(), tolerance, std::numeric_limits<double>::infinity());
    if (status != c3::NodeQp::Status::kSolved) return best;
    qp.refine(least.C(), least.t());
    v = least.v(qp.f());
    meet(condensed, qp.s(), tolerance, v);
    for (int pair = 0; pair < condensed.n_pairs; ++pair) {
      double& force = v[index_of_force(problem.sizes, pair)];
      force = zero[pair] == Side::kForce ? 0.0 : std::max(force, 0.0);
    }
    Plan plan = roll_out(problem, v);
    const bool done = best && std::abs(plan.objective - best->objective) <=
                                  kSameObjective * std::max(1.0, std::abs(plan.objective));
    best = std::move(plan);
    if (done) break;
  }
  return best;
}

std::vector<Side> modes(const Problem& problem, const Plan& plan) {
  std::vector<Side> result;
  for (int k = 0; k < problem.sizes.N; ++k) {
    const lcs::Lcs& lcs = problem.systems[k];
    const Eigen::VectorXd gap =
        lcs.E * plan.x.col(k) + lcs.F * plan.lambda.col(k) + lcs.H * plan.u.col(k) + lcs.c;
    for (int j = 0; j < problem.sizes.n_lambda; ++j) {
      result.push_back(plan.lambda(j, k) <= gap[j] ? Side::kForce : Side::kGap);
    }
  }
  return result;
}

}  // namespace c3rt::horizon
