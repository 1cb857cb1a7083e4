#pragma once

#include <vector>

#include <Eigen/Core>

#include "controller/lcs/acceptance.hpp"
#include "controller/lcs/dictionary.hpp"

namespace c3rt::lcs {

enum class LcpStatus {
  kSolved,
  kRay,         // Lemke ended on a secondary ray: for many matrices, there is no solution
  kPivotLimit,  // more pivots than any contact problem needs
  kInaccurate,  // wrong sizes, numbers that are not finite, or an answer that rounding spoilt
};

struct LcpReport {
  LcpStatus status;
  int pivots;       // of all attempts
  double residual;  // max |min(λ, F λ + q)|
  double epsilon;   // regularisation that led to the answer, 0 if none; it is not in the answer
};

/// Lemke's method for the linear complementarity problem LCP(q, F):
///
///   0 ≤ λ ⊥ F λ + q ≥ 0
///
/// Ties are broken lexicographically, so degenerate problems do not cycle. An answer is delivered
/// only if `miss` accepts it. Where the first attempt, with covering vector 1 and in double, has
/// none, there are more, in numbers of 32 digits and with rows and columns of F of one size:
///
/// 1. F + ε I, ε = 1e-8 and 1e-6. With a copositive F, that of friction, it always has an answer.
///    q − ε λ for q, as long as that helps, takes ε out of it (the proximal point method); else
///    Lemke's method goes on from the answer's basis without ε.
/// 2. ε = 0, from the basis without forces, with all of them, with those of the rows that are
///    negative and from some others: what one covering vector misses, another finds.
/// 3. Up to 8 rows: every complementary basis. Up to 6 rows: every other basis, too, as an answer
///    where w_i and λ_i are both 0 may lie on none that is complementary; with these an answer is
///    found wherever there is one.
///
/// Sizes are fixed by the constructor, which allocates; nothing else does. The number of attempts
/// does not depend on time.
class Lemke {
 public:
  explicit Lemke(int size);

  int size() const noexcept { return size_; }

  /// Room of this size for a caller that computes q and its terms and has none of its own.
  Eigen::VectorXd& q() noexcept { return q_; }
  Eigen::VectorXd& terms() noexcept { return terms_; }

  /// Overwrites `lambda` with the solution, or with zero unless the report says kSolved. With a
  /// wrong size or numbers that are not finite, kInaccurate.
  /// @param terms what each entry of q was added up from, all positive: |c| + |E x| + |H u|
  /// RT: no heap, no lock, no throw.
  [[nodiscard]] LcpReport solve(const Eigen::Ref<const Eigen::MatrixXd>& F,
                                const Eigen::Ref<const Eigen::VectorXd>& q,
                                const Eigen::Ref<const Eigen::VectorXd>& terms,
                                Eigen::Ref<Eigen::VectorXd> lambda) noexcept;

  /// The same for a q that is as given: its terms are |q|. RT: no heap, no lock, no throw.
  [[nodiscard]] LcpReport solve(const Eigen::Ref<const Eigen::MatrixXd>& F,
                                const Eigen::Ref<const Eigen::VectorXd>& q,
                                Eigen::Ref<Eigen::VectorXd> lambda) noexcept;

 private:
  struct Lcp;

  LcpStatus attempt(const Lcp& lcp, int& pivots, Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  void refine(const Lcp& lcp, const LcpMiss& missed, LcpReport& report,
              Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  bool try_harder(const Lcp& lcp, LcpReport& report, Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  bool try_regularised(const Lcp& lcp, double epsilon, LcpReport& report,
                       Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  bool try_from(const Lcp& lcp, LcpReport& report, Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  bool try_every_basis(const Lcp& lcp, LcpReport& report,
                       Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  bool try_basis(const Lcp& lcp, LcpReport& report, Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  LcpMiss take(const Lcp& lcp, LcpReport& report,
               Eigen::Ref<Eigen::VectorXd> lambda) const noexcept;
  int leaving_row(int entering) const noexcept;
  void pivot(int row, int entering) noexcept;

  using Tableau = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  int size_;
  Tableau tableau_;         // [w | λ | z0 | q] (size × (2 size + 2)); the w columns hold B⁻¹
  std::vector<int> basis_;  // column that is basic in each row
  Dictionary<DoubleDouble> dictionary_;
  Dictionary<double> small_;  // of try_every_basis
  Eigen::VectorXd q_, terms_, absolute_, first_;
  Eigen::VectorXd row_, column_;          // R and C of equilibrate
  std::vector<char> start_;               // λ that are basic at the start of an attempt
  std::vector<char> leaving_;             // w that these are exchanged for, in try_basis
  std::vector<DoubleDouble> right_side_;  // R (q − ε λ)
};

}  // namespace c3rt::lcs
