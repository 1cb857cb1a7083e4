#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "controller/c3/deadline.hpp"
#include "controller/c3/fixed_modes.hpp"
#include "controller/c3/problem.hpp"
#include "controller/lcs/lemke.hpp"
#include "controller/qp/qp_rows.hpp"
#include "controller/qp/riccati.hpp"

namespace c3rt::c3 {

/// Bits of each pair of each stage (n_lambda × N), from which the next call goes on.
using PairModes = Eigen::Matrix<unsigned char, Eigen::Dynamic, Eigen::Dynamic>;
constexpr unsigned char kForceMode = 1;  // the gap is fixed to zero, else the force
constexpr unsigned char kHeldMode = 2;   // the other side is held at zero, too
constexpr unsigned char kNoMode = 4;     // there is no plan

enum class PolishStatus {
  kOff,
  kNoPlan,    // none of the plans is complementary and meets the constraints: the solution is as
              // without polish
  kBest,      // no pair and no row that could change would bring more; moves may end by max_qps
  kQpLimit,   // Settings::polish QPs were solved before
  kDeadline,  // the deadline struck before
};

/// What polish made of a solution. Costs are those of (14), x_0's term included, of plans with
/// complementary forces; infinity where there is none that meets the constraints.
struct PolishReport {
  PolishStatus status = PolishStatus::kOff;
  double cost_before = std::numeric_limits<double>::infinity();  // of Algorithm 1's inputs
  double cost = std::numeric_limits<double>::infinity();         // of the inputs chosen
  int qps = 0;
};

/// Better plans of the whole problem (15), from plans that are known. The inputs of a known plan
/// are simulated; that fixes which side of each pair is zero, and with these modes (15) is a QP
/// over the inputs alone [FixedModes]. An active-set method goes to its minimiser, or interior
/// point iterations where that has no end, each step one Riccati recursion, so that time and memory
/// grow linearly with N. Where a pair whose both sides are zero holds it back, the signs of the two
/// sides' multipliers say whether to leave that point in this mode or, by one principal pivot, in
/// the other. A descent ends where no single pair would bring more: at a local minimum. Then moves
/// give all pairs of a contact other modes at once. Once the constraints are met the cost never
/// rises. After `set_costs` nothing allocates.
class Polish {
 public:
  /// @param max_qps  of all plans together
  Polish(const Sizes& sizes, int max_qps);

  /// Costs and constraints that passed `check`. May allocate.
  void set_costs(const Costs& costs, const Constraints& constraints);

  /// Takes a problem, which must outlive the calls that follow, Algorithm 1's inputs (n_u × N) and
  /// the forces of its last projection (n_lambda × N), whose modes inputs get that the system
  /// cannot be simulated with. Inputs are taken within their bounds. RT.
  void start(Horizon lcs, const Eigen::Ref<const Eigen::VectorXd>& x0,
             const Eigen::Ref<const Eigen::MatrixXd>& x_desired,
             const Eigen::Ref<const Eigen::MatrixXd>& u,
             const Eigen::Ref<const Eigen::MatrixXd>& lambda) noexcept;
  /// Goes down from a plan with these inputs (n_u × N), with half of the QPs that are left; not
  /// where a descent went before and what is left is too little for one. RT: no heap, no lock, no
  /// throw.
  void improve(const Eigen::Ref<const Eigen::MatrixXd>& u, const Deadline& deadline) noexcept;
  /// Goes down from a plan whose modes are known as well, as the last call's: where that ended,
  /// held pairs included. It has all QPs that a descent takes. True if that leads to the best plan.
  /// RT.
  bool resume(const Eigen::Ref<const Eigen::MatrixXd>& u, const PairModes& modes,
              const Deadline& deadline) noexcept;
  /// Spends the QPs that are left on moves: a contact's pairs get other modes over a range of
  /// stages of the best plan, and from there it goes down. The moves are drawn by the bits of x_0.
  /// RT.
  void explore(const Deadline& deadline) noexcept;

  const PolishReport& report() const noexcept { return report_; }
  /// The best plan, where report().cost is finite: x (n_x × N+1), λ (n_lambda × N), u (n_u × N).
  const Eigen::MatrixXd& x() const noexcept { return best_.x; }
  const Eigen::MatrixXd& lambda() const noexcept { return best_.s; }
  const Eigen::MatrixXd& u() const noexcept { return best_.u; }
  /// Its modes, or, where the QPs came to an end, those that its descent would go on with. RT if
  /// `modes` has the sizes already.
  void read_modes(PairModes& modes) const noexcept;

 private:
  static constexpr int kFewestQps = 6;      // that a move, or one more descent, needs
  static constexpr int kMoveQps = 20;       // of a move, or a plan whose modes are known
  static constexpr double kMet = 1e-7;      // violation of what counts as a plan
  static constexpr double kAtBound = 1e-9;  // of a value
  static constexpr double kOfValue = 1e-3;  // what none is measured beside less [unit of the row]

  /// s of a plan with modes are the sides that are not zero; of one that is simulated, λ.
  struct Plan {
    Eigen::MatrixXd x, s, u;  // (n_x × N+1), (n_lambda × N), (n_u × N)
    std::vector<char> force;  // of each pair
    double cost = 0.0;        // (14)
    double violation = 0.0;   // of sides and constraints, relative
  };
  enum class Side : char { kNone, kLower, kUpper };

  int row_count() const noexcept { return n_pairs_ + constraints_.count(); }
  bool is_pair(int row) const noexcept { return row < n_pairs_; }
  bool is_equality(int row) const noexcept;
  int stage(int row) const noexcept;
  const double* normal(int row) const noexcept;
  double along(int row, const Eigen::MatrixXd& xu, const Eigen::VectorXd& x_N) const noexcept;
  void add_normal(int row, double factor, Eigen::MatrixXd& xu, Eigen::VectorXd& x_N) const noexcept;
  double target(int row) const noexcept;
  double inverse_hessian(int row) noexcept;
  double slack(int k, int pair) const noexcept;
  void note_forces(int k, const Plan& plan) noexcept;

  void take_inputs(const Eigen::Ref<const Eigen::MatrixXd>& u) noexcept;
  bool simulate(Plan& plan) noexcept;
  bool judge(const Plan& plan) noexcept;
  void consider(const Plan& plan) noexcept;
  void keep_active() noexcept;
  void find_contacts() noexcept;
  bool draw_move() noexcept;
  int draw(int below) noexcept;
  void load(Plan& plan, bool fit) noexcept;
  void load_modes(int k, const char* force) noexcept;
  void hold_kept() noexcept;
  void begin_descent(int qps) noexcept;
  void end_descent() noexcept;
  bool is_over(const Deadline& deadline) noexcept;
  bool leap(Plan& plan, const Deadline& deadline) noexcept;
  bool hold_violated() noexcept;
  void hold_again() noexcept;
  bool fit_modes(int k, Plan& plan) noexcept;
  void take_modes(int k) noexcept;
  void roll(Plan& plan) noexcept;
  void measure(Plan& plan) noexcept;
  // where whole steps have no end: gives up; goes on
  enum class Effort : char { kQuick, kThorough };
  void descend(Plan& plan, Effort effort, const Deadline& deadline) noexcept;
  bool converge(Plan& plan, const Deadline& deadline) noexcept;
  void start_sides(const Plan& plan) noexcept;
  double distance(int side) const noexcept;
  bool interior_step() noexcept;
  void newton_step(double centre, bool corrected) noexcept;
  double longest_step(double share) const noexcept;
  bool hold_equalities() noexcept;
  void hold_touched(const Plan& plan) noexcept;
  void go_on(Plan& plan, const Deadline& deadline) noexcept;
  bool solve() noexcept;
  void penalise(int row) noexcept;
  void start_total() noexcept;
  double stiff_weight(int row) const noexcept;
  bool move(Plan& plan, double alpha) noexcept;
  void add(int row, Side side, double inverse_hessian) noexcept;
  void drop(int row) noexcept;
  void drop_all() noexcept;
  double inwards(int row) const noexcept;
  bool release(const Plan& plan) noexcept;
  bool drop_held(double enough) noexcept;
  struct Flip {
    int row;
    double gain;
  };
  Flip best_flip(double enough) noexcept;
  struct Block {
    int row;
    Side side;
    double alpha, rate;
  };
  Block first_block() const noexcept;

  Sizes sizes_, reduced_sizes_;  // of the QPs over x and u alone
  int n_pairs_;                  // N n_lambda; row k n_lambda + j is pair j of stage k
  int max_qps_;
  int limit_ = 0;  // of the QPs of the present descent
  Horizon lcs_{nullptr, 0};
  Costs costs_;
  Eigen::VectorXd x0_;
  Eigen::MatrixXd x_desired_;
  lcs::Lemke lemke_;
  PolishReport report_;
  Plan plan_, first_, candidate_, best_;                // first_: of Algorithm 1's inputs
  Eigen::MatrixXd projected_, z_, u_before_, u_first_;  // (n_z × N), (n_u × N)
  std::vector<int> contact_;  // of each pair of a stage: the first pair of its contact
  std::uint64_t random_ = 0;
  struct Move {
    int contact = 0, first = 0, last = -1;  // stages
  } move_;

  // the QP of the present modes
  std::vector<FixedModes> modes_;
  std::vector<lcs::Lcs> reduced_;
  std::vector<Eigen::MatrixXd> hessian_;  // (n_x + n_u square)
  qp::QpRows constraints_;                // rows of z; row n_pairs + i is the i-th
  Eigen::MatrixXd constraint_normals_;    // the same as rows of [x; u]
  Eigen::VectorXd constraint_offsets_;
  qp::Riccati riccati_;
  qp::RankOneTerms penalties_;
  int changed_ = 0;  // the last stage that differs from those factored
  bool modes_changed_ = true;
  bool is_loaded_ = false;  // modes_ are tables of lcs_
  double largest_force_ = 0.0;
  std::vector<int> active_;  // rows that are held
  struct Kept {
    int row;
    Side side;
    double weight, multiplier, inverse_hessian;
  };
  std::vector<Kept> kept_;  // of the best plan
  std::vector<int> again_;  // rows that `resume` holds
  /// Of interior point iterations: one finite side of a row that is no equality,
  /// sign (value − bound) = s ≥ 0 with the multiplier y ≥ 0.
  struct Inequality {
    int row;
    double sign, bound;
    double terms;  // what the value is added up from, by size
  };
  std::vector<Inequality> sides_;
  Eigen::VectorXd s_, y_, ds_, dy_, complementarity_;  // per side
  std::vector<Side> side_;
  // per row: of the penalty that holds it, multiplier, aᵀ H⁻¹ a, aᵀ [x; u] + offset
  Eigen::VectorXd weight_, multiplier_, inverse_hessian_, value_;
  Eigen::MatrixXd xu_, gradient_, total_, step_;  // (n_x + n_u × N)
  Eigen::MatrixXd no_defect_;                     // (n_x × N)
  Eigen::VectorXd gradient_N_, total_N_, step_N_, p_, p_next_;
};

}  // namespace c3rt::c3
