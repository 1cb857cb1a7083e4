#pragma once

#include <vector>

#include <Eigen/Core>

#include "controller/lcs/double_double.hpp"

namespace c3rt::lcs {

/// The equations w − F λ − 1 z0 = q of an LCP, solved for n of their 2 n + 1 variables, the basic
/// ones [Cottle, Pang, Stone 1992, ch. 2 and 4]:
///
///   basic + T other = b
///
/// Variables are numbered w_i = i, λ_i = n + i, z0 = 2 n. Only the columns of the others are held,
/// so that an exchange costs half of one in a full tableau. `Number` is double, or DoubleDouble
/// where the order of nearly equal ratios must not be rounding's; dictionary.cpp has these two.
/// Sizes are fixed by the constructor, which allocates; nothing else does.
template <typename Number>
class Dictionary {
 public:
  explicit Dictionary(int size);

  /// Of R (F + ε R⁻¹C⁻¹) C and R q, R and C diagonal, with all w basic.
  void load(const Eigen::Ref<const Eigen::MatrixXd>& F, const Eigen::Ref<const Eigen::VectorXd>& q,
            const Eigen::VectorXd& R, const Eigen::VectorXd& C, double epsilon) noexcept;

  /// Exchanges w_i and λ_i of all i with `wanted[i]`, largest pivot first and none below
  /// `smallest`, or of as many as can be, one or two at a time; call it after load. Returns whether
  /// they all were.
  bool exchange(const std::vector<char>& wanted, double smallest) noexcept;

  /// Exchanges as many w, those of `leaving`, for the λ of `entering`, in the same way; the basis
  /// need not be complementary. All of them or, where that is no basis, none; returns which.
  bool exchange(const std::vector<char>& leaving, const std::vector<char>& entering,
                double smallest) noexcept;

  /// b of another q̃ in the same basis.
  void set_right_side(const std::vector<Number>& q) noexcept;

  enum class End { kSolved, kRay, kPivotLimit };

  /// Lemke's method with covering vector 1 from the basis at hand, whichever complementary one it
  /// is; ties are broken lexicographically. An entry below `smallest` beside the largest of its
  /// column is no pivot.
  End cover(int pivot_limit, double smallest) noexcept;

  bool is_basic(int variable) const noexcept { return where_[variable] >= 0; }
  /// 0 unless basic.
  Number value(int variable) const noexcept {
    return is_basic(variable) ? at(where_[variable], n_ + 1) : Number{};
  }
  /// Exchanges since load.
  int pivots() const noexcept { return pivots_; }

 private:
  Number& at(int row, int column) noexcept { return entries_[row * (n_ + 2) + column]; }
  const Number& at(int row, int column) const noexcept { return entries_[row * (n_ + 2) + column]; }
  Number of_variable(int row, int variable) const noexcept;
  bool before(int i, int j, int column) const noexcept;
  void pivot(int row, int column) noexcept;

  int n_;
  std::vector<Number> entries_;      // [T | z0 or what it was exchanged for | b], by rows
  std::vector<int> basic_, other_;   // variable of each row (n) and column (n + 1)
  std::vector<int> where_;           // of each variable: its row, or −1 − its column
  std::vector<int> first_;           // basic variables at the start of `cover`
  std::vector<int> rows_, columns_;  // of exchanges that may have to be undone
  int pivots_ = 0;
};

}  // namespace c3rt::lcs
