#pragma once

#include <vector>

#include <Eigen/Core>

namespace c3rt::qp {

/// The QP of one branch-and-bound node, as the least distance from the origin:
///
///   min ½ ‖f‖²   with   s = t + Cᵀ f,   s_i ≥ 0, or s_i = 0 if i is pinned
///
/// Dual active set method [Goldfarb, Idnani 1983]: starts from the unconstrained minimiser and adds
/// one violated constraint at a time, so that a constraint pinned in a solved state costs only the
/// steps that it needs. The active constraints are kept as an orthonormal basis Q and a triangle,
/// not by their Gram matrix, whose condition is the square: contact rows are nearly dependent (the
/// slips along +t and −t add up to γ).
class NodeQp {
 public:
  enum class Status { kSolved, kInfeasible, kAboveBound, kStuck };

  NodeQp(Eigen::Index n_variables, Eigen::Index n_constraints);

  /// The unconstrained minimiser: f = 0, s = t, nothing pinned.
  void start(const Eigen::VectorXd& t) noexcept;

  /// From now on s_i = 0.
  void pin(int i) noexcept { pinned_[i] = 1; }

  /// Solves from the present state. Returns early once the objective is above `bound`.
  /// @param C          (n_variables × n_constraints), columns of length 1 (or 0)
  /// @param tolerance  how far s may be below zero, or a pinned one from it
  /// RT: no heap, no lock, no throw.
  Status solve(const Eigen::MatrixXd& C, const Eigen::VectorXd& t, double tolerance,
               double bound) noexcept;

  /// Moves f onto the active constraints once more, which takes out the rounding that the path to
  /// them has accumulated. RT: no heap, no lock, no throw.
  void refine(const Eigen::MatrixXd& C, const Eigen::VectorXd& t) noexcept;

  /// Goes on with another t: the active constraints stay at zero, those that would have to be
  /// pushed below it leave. `solve` may follow. RT: no heap, no lock, no throw.
  void restart(const Eigen::MatrixXd& C, const Eigen::VectorXd& t) noexcept;

  /// Copies what `solve` needs, nothing more.
  void copy_from(const NodeQp& other) noexcept;

  const Eigen::VectorXd& f() const noexcept { return f_; }
  const Eigen::VectorXd& s() const noexcept { return s_; }
  double objective() const noexcept { return 0.5 * f_.squaredNorm(); }
  bool is_pinned(int i) const noexcept { return pinned_[i] != 0; }

  /// The active constraints, in the order of what follows.
  int n_active() const noexcept { return n_active_; }
  int active(int i) const noexcept { return active_[i]; }
  /// Turns t of the active constraints into the multipliers that bring these to zero.
  void multipliers(Eigen::Ref<Eigen::VectorXd> t) const noexcept;
  /// The smallest f that moves the active s by −`s`.
  Eigen::VectorXd against(Eigen::VectorXd s) const;

  /// After kInfeasible: the constraint that cannot be met, with `sign`, and the active ones with
  /// −sign `coefficients` add up to what is at least zero wherever these hold, is −violation at f,
  /// and hardly changes with f.
  struct Contradiction {
    int constraint;
    double sign;
    double violation;               // |s|
    double weight;                  // 1 + Σ|coefficients|
    Eigen::VectorXd coefficients;   // in the order of the active ones
    const Eigen::VectorXd& normal;  // how it changes with f, but for the sign
  };
  Contradiction contradiction() const;

 private:
  /// Splits column p of C into its part along the active ones (r_: its coefficients) and the rest
  /// (z_). Returns ‖z‖.
  double split(const Eigen::MatrixXd& C, int p) noexcept;
  void append(int p, double length) noexcept;
  void remove(int position) noexcept;
  void update_s(const Eigen::MatrixXd& C, const Eigen::VectorXd& t) noexcept;

  Eigen::VectorXd f_, s_, mu_;  // mu: multipliers
  std::vector<char> pinned_, is_active_;
  int n_active_ = 0;
  int contradicted_ = 0;     // where kInfeasible ended
  std::vector<int> active_;  // active constraints; the first n_active_ count
  Eigen::MatrixXd Q_;        // orthonormal basis of the active columns of C
  // active columns = Q Lᵀ, L lower triangular
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> L_;
  Eigen::VectorXd l_, again_, r_, z_;
};

}  // namespace c3rt::qp
