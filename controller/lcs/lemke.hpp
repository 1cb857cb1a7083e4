#pragma once

#include <vector>

#include <Eigen/Core>

namespace c3rt::lcs {

enum class LcpStatus {
  kSolved,
  kRay,         // Lemke ended on a secondary ray: for many matrices, there is no solution
  kPivotLimit,  // more pivots than any contact problem needs
  kInaccurate,  // a basis was found, but rounding spoilt it (see LcpReport::residual)
};

struct LcpReport {
  LcpStatus status;
  int pivots;       // of all attempts
  double residual;  // max |min(λ, F λ + q)| of the unregularised problem
  double epsilon;   // regularisation that was needed, 0 if none
};

/// Lemke's method with covering vector 1 for the linear complementarity problem LCP(q, F):
///
///   0 ≤ λ ⊥ F λ + q ≥ 0
///
/// Ties are broken lexicographically, so degenerate problems do not cycle. Sizes are fixed by the
/// constructor, which allocates; nothing else does.
class Lemke {
 public:
  explicit Lemke(int size);

  int size() const noexcept { return size_; }

  /// Room of this size for a caller that computes q and has none of its own.
  Eigen::VectorXd& q() noexcept { return q_; }

  /// Overwrites `lambda` with the solution, or with zero unless the report says kSolved. Where the
  /// problem as it is given has no answer that is exact in every row, beside the terms of that row,
  /// it is tried again with rows and columns of F brought to the same size. With a wrong size or
  /// numbers that are not finite, kInaccurate. RT: no heap, no lock, no throw.
  [[nodiscard]] LcpReport solve(const Eigen::Ref<const Eigen::MatrixXd>& F,
                                const Eigen::Ref<const Eigen::VectorXd>& q,
                                Eigen::Ref<Eigen::VectorXd> lambda) noexcept;

  /// `solve`, and where it fails the same with F + ε I for ε = 1e-12, 1e-10 … 1e-2 times the
  /// largest |F_ij|. The answer then solves the regularised problem; report.residual says how well
  /// the given one. RT: no heap, no lock, no throw.
  [[nodiscard]] LcpReport solve_regularised(const Eigen::Ref<const Eigen::MatrixXd>& F,
                                            const Eigen::Ref<const Eigen::VectorXd>& q,
                                            Eigen::Ref<Eigen::VectorXd> lambda) noexcept;

 private:
  LcpReport attempt(const Eigen::Ref<const Eigen::MatrixXd>& F,
                    const Eigen::Ref<const Eigen::VectorXd>& q, double epsilon, bool scaled,
                    Eigen::Ref<Eigen::VectorXd> lambda) noexcept;
  void equilibrate(const Eigen::Ref<const Eigen::MatrixXd>& F) noexcept;
  int leaving_row(int entering) const noexcept;
  void pivot(int row, int entering) noexcept;

  using Tableau = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  int size_;
  Tableau tableau_;         // [w | λ | z0 | q] (size × (2 size + 2)); the w columns hold B⁻¹
  std::vector<int> basis_;  // column that is basic in each row
  Eigen::VectorXd q_, first_;
  Eigen::VectorXd row_, column_;  // factors of equilibrate, powers of 2
};

}  // namespace c3rt::lcs
