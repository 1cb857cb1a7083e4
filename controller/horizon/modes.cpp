#include "controller/horizon/modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace c3rt::horizon {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = 1e-8;     // curvature that the cost gets, of its diagonal
constexpr double kTolerance = 1e-12;  // of the largest normalised |s| at the free minimiser
constexpr double kSettled = 1e-11;    // distance from the lower bound, of the objective
constexpr double kSameObjective = 1e-13;
constexpr int kMaxCentres = 30;

}  // namespace

std::optional<Plan> solve_modes(const Problem& problem, const std::vector<Side>& zero) {
  const Condensed condensed = condense(problem, zero);
  const LeastDistance least(condensed, kEpsilon);
  LeastDistance::Centre centre;
  least.place(Eigen::VectorXd::Zero(condensed.g.size()), centre);
  qp::NodeQp qp(condensed.H.rows(), condensed.J.rows());
  qp.start(centre.t);
  for (const int row : condensed.equalities) qp.pin(row);
  return solve_modes(problem, zero, condensed, least, qp, centre);
}

std::optional<Plan> solve_modes(const Problem& problem, const std::vector<Side>& zero,
                                const Condensed& condensed, const LeastDistance& least,
                                qp::NodeQp& qp, LeastDistance::Centre& centre) {
  for (int pair = 0; pair < condensed.n_pairs; ++pair) {
    qp.pin(zero[pair] == Side::kForce ? pair : condensed.n_pairs + pair);
  }
  // λ has no cost of its own: the QP that is definite around a centre is solved around its last
  // minimiser, until that changes nothing (proximal point method)
  std::optional<Plan> best;
  double before = kInfinity;
  for (int i = 0; i < kMaxCentres; ++i) {
    const double tolerance = kTolerance * centre.t.lpNorm<Eigen::Infinity>();
    if (qp.solve(least.C(), centre.t, tolerance, kInfinity) != qp::NodeQp::Status::kSolved) break;
    qp.refine(least.C(), centre.t);
    Eigen::VectorXd v = least.normalised(centre, qp.f());
    least.meet(qp, v);
    Plan plan = roll_out(problem, condensed, least.original(v), zero);
    const double objective = plan.objective;
    if (residual(problem, plan) <= kMet && (!best || objective < best->objective))
      best = std::move(plan);
    const LeastDistance::Bound bound = least.lower_bound(centre, qp, kInfinity);
    if (objective - bound.value <= kSettled * objective ||
        std::abs(objective - before) <= kSameObjective * objective)
      break;
    before = objective;
    least.place(bound.v, centre);
    qp.restart(least.C(), centre.t);
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
