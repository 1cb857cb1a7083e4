#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "controller/horizon/feedback.hpp"
#include "controller/horizon/problem.hpp"
#include "controller/qp/node_qp.hpp"

namespace c3rt::horizon {

/// The problem without its states:
///
///   minimise vᵀ H v + 2 gᵀ v + constant,   v = [v_0; … v_{N−1}],   [u_k; λ_k] = v_k + K_k x_k
///   with     s = J v + c ≥ 0, of pairs (i, n_pairs + i) one zero, of equalities all zero
///
/// s = [λ; y; the one-sided constraints], y = E x + F λ + H u + c. The feedback K keeps the entries
/// of H and J from growing with N where the system is unstable; else it is zero.
struct Condensed {
  Eigen::MatrixXd H;  // (n_v × n_v) positive semidefinite
  Eigen::VectorXd g;  // (n_v)
  double constant = 0.0;
  Eigen::MatrixXd J;               // (rows × n_v)
  Eigen::VectorXd c;               // (rows)
  int n_pairs = 0;                 // N n_lambda; pair i = k n_lambda + j
  std::vector<int> equalities;     // rows
  std::vector<Eigen::MatrixXd> K;  // of each stage (n_u + n_lambda × n_x)
};

/// @param zero  modes that the plan will have (see stabilising_feedback), or empty
Condensed condense(const Problem& problem, const std::vector<Side>& zero = {});

/// The plan of v and of these modes, simulated closed loop, so that rounding does not grow with the
/// system: forces that are zero are exactly so, and no force or input is beyond its bounds by the
/// rounding of v.
Plan roll_out(const Problem& problem, const Condensed& condensed, const Eigen::VectorXd& v,
              const std::vector<Side>& zero);

/// The v of a trajectory.
Eigen::VectorXd inputs_of(const Problem& problem, const Condensed& condensed, const Plan& plan);

/// A condensed problem as the least distance from the origin that qp::NodeQp solves. Its quadratic
/// term, which forces without a cost of their own leave singular, is made definite around a centre;
/// `lower_bound` takes that out again. Works on v in units in which H has a unit diagonal, so that
/// the units of forces do not matter:
///
///   vᵀ H v + 2 gᵀ v + ε ‖v − v_c‖² = lowest + ‖f‖²,   s = (t + Cᵀ f)/scale
class LeastDistance {
 public:
  /// @param epsilon  ε, relative to the unit diagonal
  LeastDistance(const Condensed& condensed, double epsilon);

  /// Where the quadratic term is made definite, and what depends on it.
  struct Centre {
    Eigen::VectorXd v;     // v_c in the units of H
    Eigen::VectorXd half;  // L⁻¹ (g − ε v_c)
    Eigen::VectorXd t;     // (rows)
    double lowest = 0.0;   // with the problem's constant
  };
  void place(const Eigen::VectorXd& v, Centre& centre) const;

  const Eigen::MatrixXd& C() const noexcept {
    return C_;
  }  // (n_v × rows), columns of length 1 or 0

  /// v in the units of H, and in the problem's.
  Eigen::VectorXd normalised(const Centre& centre, const Eigen::VectorXd& f) const;
  Eigen::VectorXd normalised(const Eigen::VectorXd& v) const { return v.cwiseQuotient(unit_); }
  Eigen::VectorXd original(const Eigen::VectorXd& v) const { return v.cwiseProduct(unit_); }

  /// Moves v (in the units of H) onto the active constraints as they are without L, whose condition
  /// has left them some digits away.
  void meet(const qp::NodeQp& qp, Eigen::VectorXd& v) const;

  struct Bound {
    double value;           // no plan within reach of `v` costs less
    double curvature_loss;  // how much of it the curvature has cost; 0 where less than rounding
    Eigen::VectorXd v;      // where it was found (in the units of H)
  };
  /// A lower bound of the problem *without* ε, with the inequalities as they are and the pinned
  /// rows at zero: the dual function at multipliers of the active constraints around a centre that
  /// has converged. With v the minimiser of the Lagrangian and v_c the centre, any other v' costs
  /// at least
  ///
  ///   dual − ε ‖v − v_c‖² − 2 ε ‖v − v_c‖ ‖v' − v‖
  ///
  /// which kReach bounds. Less an allowance for rounding.
  /// @param enough  no better bound is needed
  Bound lower_bound(const Centre& centre, const qp::NodeQp& qp, double enough) const;

  /// How far from v (in the units of H) a plan could be that is cheaper than the bounds say: this
  /// many times the size of v and of the problem's cost.
  static constexpr double kReach = 1e6;
  double reach(const Eigen::VectorXd& v) const;

  /// After a QP that has no solution: below which costs that is shown. Infinity where no plan
  /// within reach meets the constraints; a cost where rounding leaves only that one would have to
  /// cost more.
  /// @param enough  no better bound is needed
  double infeasible_below(const Centre& centre, const qp::NodeQp& qp, double enough) const;

 private:
  using Multipliers = std::function<Eigen::VectorXd(Eigen::VectorXd t)>;
  /// The bound at multipliers of these rows, which are found when their t around v_c is.
  Bound dual(const Eigen::VectorXd& v_c, const std::vector<int>& rows,
             const Multipliers& multipliers) const;
  /// The best of the bounds around v_c, the minimiser that this gives, and so on.
  Bound best_bound(Eigen::VectorXd v_c, const std::vector<int>& rows,
                   const Multipliers& multipliers, double enough) const;

  const Condensed* condensed_;
  double epsilon_;
  Eigen::VectorXd unit_, g_;  // of v: v_original = unit v; g in these units
  Eigen::MatrixXd L_;         // H + ε = L Lᵀ, lower triangle
  Eigen::MatrixXd C_;
  Eigen::VectorXd scale_;  // of the rows
};

}  // namespace c3rt::horizon
