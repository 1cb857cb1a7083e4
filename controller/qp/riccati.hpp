#pragma once

#include <vector>

#include <Eigen/Core>

#include "controller/qp/kernels.hpp"
#include "controller/qp/problem.hpp"
#include "controller/qp/qp_cost.hpp"

namespace c3rt::qp {

/// Terms w a aᵀ of the Hessians H_k, or of H_N (stage N), kept beside them: most differ by these
/// alone, of which few have more than one entry.
class RankOneTerms {
 public:
  struct Term {
    int coordinate;        // of the entry 1 of a; −1: a is `normal`
    const double* normal;  // (n_z), or (n_x) of stage N
    double weight;
    int next;  // of the same stage, −1: none
  };

  /// For stages 0 … N and so many terms. May allocate.
  void prepare(int N, int terms);
  void clear() noexcept;
  /// `normal` must outlive the use. RT.
  void add(int stage, int coordinate, const double* normal, double weight) noexcept;

  int first(int stage) const noexcept { return first_[stage]; }
  const Term& operator[](int i) const noexcept { return terms_[i]; }

 private:
  std::vector<int> first_;  // of each stage, −1: none
  std::vector<Term> terms_;
};

/// Newton steps of
///
///   min Σ_{k<N} ½ z_kᵀ H_k z_k + ½ x_Nᵀ H_N x_N + linear terms,   x_{k+1} = A x_k + B̂ ν_k + d, x_0
///   given
///
/// over the inputs ν = [λ; u], B̂ = [D B], by the Riccati recursion: time and memory grow linearly
/// with N. States are variables of their own: a point may miss the dynamics by its defects, which a
/// step takes out, so that nothing is ever rolled out with the open loop, whose rounding would grow
/// as ρ(A)^N. `factor` runs it for the Hessians once, `step` uses it for any gradient. Zeros of A
/// and B̂ are found in `start` and never multiplied with matrices; x_0 does not move, so stage 0
/// takes part with its ν only, and where λ_0 is fixed with its u only. After the constructor
/// nothing allocates.
class Riccati {
 public:
  explicit Riccati(const Sizes& sizes);

  /// Takes the systems, which must outlive the calls of everything below. RT.
  void start(Horizon lcs, bool lambda_0_fixed) noexcept;

  /// @param H    (n_z × n_z) symmetric
  /// @param H_N  (n_x × n_x) symmetric
  /// @param last  the last stage whose H or rank_one_terms differ from those of the factorisation
  /// before,
  ///              whose results behind it are kept; N: all are new
  /// @param rank_one_terms  added to the Hessians; nullptr: none
  /// False if the problem is not strictly convex in ν, or beyond double precision. RT.
  [[nodiscard]] bool factor(StageMatrices H, const Eigen::MatrixXd& H_N, int last,
                            const RankOneTerms* rank_one_terms = nullptr) noexcept;
  [[nodiscard]] bool factor(StageMatrices H, const Eigen::MatrixXd& H_N) noexcept {
    return factor(H, H_N, sizes_.N);
  }

  /// Largest entry of B̂ by size.
  double largest_gain() const noexcept { return largest_gain_; }

  /// What x_{k+1} of a point has beyond A x_k + B̂ ν_k + d, into column k (n_x × N). RT.
  void defects(const Eigen::Ref<const Eigen::MatrixXd>& z,
               const Eigen::Ref<const Eigen::VectorXd>& x_N,
               Eigen::MatrixXd& defect) const noexcept;
  /// The largest of these defects beside the largest term of its stage; NaN if one is. RT.
  double relative_defect(const Eigen::Ref<const Eigen::MatrixXd>& z,
                         const Eigen::Ref<const Eigen::VectorXd>& x_N,
                         const Eigen::MatrixXd& defect) noexcept;

  /// A step beside the point z (n_z × N each): the largest ratio of the largest entries of x, of λ
  /// and of u. RT.
  double relative_step(const Eigen::MatrixXd& step,
                       const Eigen::Ref<const Eigen::MatrixXd>& z) noexcept;

  /// How far a gradient in z and x_N is from zero once multipliers p_1 … p_N of the dynamics are
  /// added: g_ν + B̂ᵀ p_{k+1} in the inputs, g_x + Aᵀ p_{k+1} − p_k in the states. The multipliers
  /// come from the last factorisation's recursion, so that they are a closed loop's: those that
  /// make the part in the states zero, p_k = g_x + Aᵀ p_{k+1}, grow as ρ(A)^N with what the part in
  /// the inputs misses.
  struct Stationarity {
    double input = 0.0, state = 0.0;              // largest component by size; NaN if one is
    double input_scale = 0.0, state_scale = 0.0;  // the largest term that these are made of
    double input_sum = 0.0, state_sum = 0.0;      // of all components by size
    // false where rounding alone leaves λ or u fewer digits, beside 1 and the largest of its stage,
    // than an answer has that is called solved
    bool is_known = true;
    double defect = 0.0;  // Σ p_{k+1}ᵀ defect_k
  };
  /// RT.
  /// @param gradient    of stage k in column k (n_z × N)
  /// @param gradient_N  (n_x)
  /// @param z           (n_z × N) where the gradient was taken, only for Stationarity::is_known
  Stationarity stationarity(const Eigen::MatrixXd& gradient, const Eigen::VectorXd& gradient_N,
                            const Eigen::Ref<const Eigen::MatrixXd>& z) noexcept;
  /// The same of a gradient that was taken nowhere. RT.
  /// @param defect      (n_x × N), only for Stationarity::defect
  Stationarity stationarity_of_multipliers(const Eigen::MatrixXd& gradient,
                                           const Eigen::VectorXd& gradient_N,
                                           const Eigen::MatrixXd& defect) noexcept;

  /// How far aᵀ z_k (k < N) or aᵀ x_N moves for a unit multiplier: aᵀ H⁻¹ a of the whole problem,
  /// or at least the part of it that the inputs of the last few stages up to k bring. RT.
  /// @param a  (n_z), or (n_x) with k = N
  double inverse_hessian_along(int k, const Eigen::Ref<const Eigen::VectorXd>& a) noexcept;

  /// The change of z and x_N that minimises the model with this gradient and takes the defects out.
  /// RT.
  void step(const Eigen::MatrixXd& gradient, const Eigen::VectorXd& gradient_N,
            const Eigen::MatrixXd& defect, Eigen::MatrixXd& step_z,
            Eigen::VectorXd& step_N) noexcept;

 private:
  /// A matrix by columns without its zeros (see kernels::Columns).
  struct Sparse {
    std::vector<int> start, row;
    std::vector<double> value;
    kernels::Columns columns() const noexcept { return {start.data(), row.data(), value.data()}; }
  };
  struct System {
    Sparse A, B_hat;
    std::vector<double> next;             // [A B̂], x_{k+1} = next z_k + d    (n_x × n_z)
    std::vector<double> next_transposed;  // (n_z × n_x)
  };
  struct Stage {
    std::vector<double> L, L_inverse;  // L Lᵀ = R̂ = H_νν + B̂ᵀ P B̂, and 1/L_jj
    std::vector<double> T;             // (L⁻¹ S)ᵀ, S = H_νx + B̂ᵀ P A    (n_x × n_nu)
    std::vector<double> P_next;        // of the cost-to-go behind this stage    (n_x × n_x)
    std::vector<double> kappa;         // L⁻¹ (gradient of ν)
  };

  const System& system(int k) const noexcept { return systems_[k * lcs_.stride]; }
  /// First entry of ν_k that is free.
  int first(int k) const noexcept { return k == 0 && lambda_0_fixed_ ? sizes_.n_lambda : 0; }
  bool factor_inputs(int k, const Eigen::MatrixXd& H, const RankOneTerms* rank_one_terms) noexcept;
  Stationarity look(const Eigen::MatrixXd& gradient, const Eigen::VectorXd& gradient_N,
                    const Eigen::MatrixXd* defect, const double* z) noexcept;
  void eliminate_inputs(int k, const Eigen::MatrixXd& H,
                        const RankOneTerms* rank_one_terms) noexcept;

  Sizes sizes_;
  int n_nu_;
  int ld_x_, ld_nu_, ld_z_;  // padded
  Horizon lcs_{nullptr, 0};
  bool lambda_0_fixed_ = false;
  double largest_gain_ = 0.0;
  std::vector<System> systems_;
  std::vector<Stage> stages_;
  std::vector<double> PA_, AP_, PB_, BP_, R_;
  std::vector<double> p_, x_, x_next_, nu_, z_, terms_;
  std::vector<double> of_defects_, of_states_;  // largest of each stage    (N)
  std::vector<double> dynamics_terms_, left_;   // of a gradient, see `look`    (n_z × N)
};

/// Stationarity beside its terms, of which `terms` are those of the gradient.
/// @param gain  largest entry of B̂
double relative(const Riccati::Stationarity& found, const QpCost::Terms& terms,
                double gain) noexcept;

}  // namespace c3rt::qp
