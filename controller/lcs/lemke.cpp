#include "controller/lcs/lemke.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace c3rt::lcs {
namespace {

// Of the tableau in double: an entry this small beside the largest of its column is rounding, not a
// pivot, and ratios this close (beside the larger one) are a tie, which the lexicographic rule
// breaks.
constexpr double kPivotTolerance = 1e-11;
constexpr double kTieTolerance = 1e-12;
// Of the dictionary. With ε the smallest true pivots are some ε², without it the data's rounding,
// 1e-17, is not to be taken for one.
constexpr double kRegularisedPivot = 1e-20;
constexpr double kSmallestPivot = 1e-11;
constexpr int kEveryBasis = 8;   // rows of which all 2^n bases are tried
constexpr int kEveryVertex = 6;  // rows of which every other basis is tried as well, of C(2n, n)
constexpr int kOtherStarts = 4;  // with more rows
constexpr int kProximalSteps = 8;
// LcpMiss::relative of an answer that need not be made more exact.
constexpr double kExactEnough = 0.01;
constexpr double kLikeUnits = 1e6;

}  // namespace

/// What the attempts share.
struct Lemke::Lcp {
  const Eigen::Ref<const Eigen::MatrixXd>& F;
  const Eigen::Ref<const Eigen::VectorXd>& q;
  const Eigen::Ref<const Eigen::VectorXd>& terms;
};

Lemke::Lemke(int size)
    : size_(size),
      tableau_(size, 2 * size + 2),
      basis_(size),
      dictionary_(size),
      small_(size <= kEveryBasis ? size : 0),
      q_(size),
      terms_(size),
      absolute_(size),
      first_(size),
      row_(Eigen::VectorXd::Ones(size)),
      column_(Eigen::VectorXd::Ones(size)),
      start_(size),
      leaving_(size),
      right_side_(size) {}

LcpReport Lemke::solve(const Eigen::Ref<const Eigen::MatrixXd>& F,
                       const Eigen::Ref<const Eigen::VectorXd>& q,
                       Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  if (q.size() == size_) absolute_ = q.cwiseAbs();
  return solve(F, q, absolute_, lambda);
}

LcpReport Lemke::solve(const Eigen::Ref<const Eigen::MatrixXd>& F,
                       const Eigen::Ref<const Eigen::VectorXd>& q,
                       const Eigen::Ref<const Eigen::VectorXd>& terms,
                       Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const int n = size_;
  lambda.setZero();
  if (F.rows() != n || F.cols() != n || q.size() != n || terms.size() != n || lambda.size() != n ||
      !F.allFinite() || !q.allFinite() || !terms.allFinite()) {
    return {LcpStatus::kInaccurate, 0, HUGE_VAL, 0.0};
  }
  if (n == 0 || q.minCoeff() >= 0.0) return {LcpStatus::kSolved, 0, 0.0, 0.0};

  const Lcp lcp{F, q, terms};
  LcpReport report{LcpStatus::kRay, 0, 0.0, 0.0};
  report.status = attempt(lcp, report.pivots, lambda);
  if (report.status == LcpStatus::kSolved && is_exact(F, q, terms, lambda, report.residual))
    return report;
  equilibrate(F, terms, row_, column_);
  if (report.status == LcpStatus::kSolved) {
    const LcpMiss missed = miss(F, q, terms, row_, column_, lambda);
    report.residual = missed.residual;
    // in units of very different size, what is rounding of one force is all of another
    const bool units_are_like = row_.maxCoeff() < kLikeUnits * row_.minCoeff() &&
                                column_.maxCoeff() < kLikeUnits * column_.minCoeff();
    if (units_are_like && missed.relative <= kExactEnough) return report;
    for (int i = 0; i < n; ++i) start_[i] = 0;
    for (const int basic : basis_) {
      if (basic >= n && basic < 2 * n) start_[basic - n] = 1;
    }
    refine(lcp, missed, report, lambda);
    if (report.status == LcpStatus::kSolved) return report;
  }
  if (try_harder(lcp, report, lambda)) return report;
  lambda.setZero();
  report.residual = -q.minCoeff();
  report.epsilon = 0.0;
  return report;
}

bool Lemke::try_harder(const Lcp& lcp, LcpReport& report,
                       Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const int n = size_;
  for (const double epsilon : {1e-8, 1e-6}) {
    if (try_regularised(lcp, epsilon, report, lambda)) return true;
    if (try_from(lcp, report, lambda)) return true;
  }
  const auto try_start = [&](const auto& has_force) {
    for (int i = 0; i < n; ++i) start_[i] = has_force(i);
    return try_from(lcp, report, lambda);
  };
  if (try_start([](int) { return false; })) return true;
  const LcpStatus why_not = report.status;
  if (try_start([](int) { return true; })) return true;
  if (try_start([&](int i) { return lcp.q[i] < 0.0; })) return true;
  if (n <= kEveryBasis && try_every_basis(lcp, report, lambda)) return true;
  std::uint64_t random = 1;  // Lehmer's generator
  for (int other = 0; n > kEveryBasis && other < kOtherStarts; ++other) {
    if (try_start([&](int) { return ((random = random * 48271 % 2147483647) >> 16) % 2 == 1; }))
      return true;
  }
  report.status = why_not;
  return false;
}

/// What the dictionary has, and whether it is an answer, in the report.
LcpMiss Lemke::take(const Lcp& lcp, LcpReport& report,
                    Eigen::Ref<Eigen::VectorXd> lambda) const noexcept {
  for (int i = 0; i < size_; ++i)
    lambda[i] = column_[i] * std::max(dictionary_.value(size_ + i).high, 0.0);
  const LcpMiss missed = miss(lcp.F, lcp.q, lcp.terms, row_, column_, lambda);
  report.status = missed.accepted() ? LcpStatus::kSolved : LcpStatus::kInaccurate;
  report.residual = missed.residual;
  return missed;
}

/// The answer of the basis of start_, in 32 digits, if it misses less than the one that is there.
void Lemke::refine(const Lcp& lcp, const LcpMiss& missed, LcpReport& report,
                   Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  first_ = lambda;
  dictionary_.load(lcp.F, lcp.q, row_, column_, 0.0);
  dictionary_.exchange(start_, kSmallestPivot);
  report.pivots += dictionary_.pivots();
  if (take(lcp, report, lambda).relative <= missed.relative) return;
  lambda = first_;
  report.status = missed.accepted() ? LcpStatus::kSolved : LcpStatus::kInaccurate;
  report.residual = missed.residual;
}

/// The answer for F + ε I, and those of q − ε λ in its place, until ε is not in it.
bool Lemke::try_regularised(const Lcp& lcp, double epsilon, LcpReport& report,
                            Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const int n = size_, pivot_limit = 50 + 20 * n;
  dictionary_.load(lcp.F, lcp.q, row_, column_, epsilon);
  report.status = LcpStatus::kRay;
  LcpMiss missed{0.0, 0.0};
  for (int step = 0; step < kProximalSteps; ++step) {
    if (step > 0) {
      for (int i = 0; i < n; ++i) {
        DoubleDouble force = dictionary_.value(n + i);
        if (force.high < 0.0) force = {};
        right_side_[i] = DoubleDouble{row_[i] * lcp.q[i]} - DoubleDouble{epsilon} * force;
      }
      dictionary_.set_right_side(right_side_);
    }
    if (dictionary_.cover(pivot_limit, kRegularisedPivot) != Dictionary<DoubleDouble>::End::kSolved)
      break;
    missed = take(lcp, report, lambda);
    if (missed.relative <= kExactEnough) break;
  }
  report.pivots += dictionary_.pivots();
  report.epsilon = epsilon;
  for (int i = 0; i < n; ++i) start_[i] = dictionary_.is_basic(n + i);
  if (report.status != LcpStatus::kSolved) return false;
  refine(lcp, missed, report, lambda);
  return true;
}

/// Lemke's method from the basis of the λ in start_, or from as many of them as there is one.
bool Lemke::try_from(const Lcp& lcp, LcpReport& report,
                     Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  dictionary_.load(lcp.F, lcp.q, row_, column_, 0.0);
  dictionary_.exchange(start_, kSmallestPivot);
  take(lcp, report, lambda);
  if (report.status != LcpStatus::kSolved) {
    using End = Dictionary<DoubleDouble>::End;
    const End end = dictionary_.cover(50 + 20 * size_, kSmallestPivot);
    if (end == End::kSolved) take(lcp, report, lambda);
    if (end == End::kRay) report.status = LcpStatus::kRay;
    if (end == End::kPivotLimit) report.status = LcpStatus::kPivotLimit;
  }
  report.pivots += dictionary_.pivots();
  return report.status == LcpStatus::kSolved;
}

bool Lemke::try_every_basis(const Lcp& lcp, LcpReport& report,
                            Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const unsigned all = 1U << size_;
  const auto select = [this](unsigned mode, std::vector<char>& selected) {
    for (int i = 0; i < size_; ++i) selected[i] = (mode >> i & 1U) != 0;
    return std::count(selected.begin(), selected.end(), char{1});
  };
  for (unsigned mode = 1; mode < all; ++mode) {
    select(mode, start_);
    leaving_ = start_;
    if (try_basis(lcp, report, lambda)) return true;
  }
  // Of each mode, the answers are a polyhedron that has a vertex, and a vertex has a basis, of
  // which what does not belong to the mode is 0.
  for (unsigned mode = 1; size_ <= kEveryVertex && mode < all; ++mode) {
    const auto forces = select(mode, start_);
    for (unsigned other = 1; other < all; ++other) {
      if (other == mode || select(other, leaving_) != forces) continue;
      if (try_basis(lcp, report, lambda)) return true;
    }
  }
  return false;
}

/// The basis where the λ of start_ are exchanged for the w of leaving_.
bool Lemke::try_basis(const Lcp& lcp, LcpReport& report,
                      Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const auto load_into = [&](auto& dictionary) {
    dictionary.load(lcp.F, lcp.q, row_, column_, 0.0);
    const bool is_basis = start_ == leaving_
                              ? dictionary.exchange(start_, kSmallestPivot)
                              : dictionary.exchange(leaving_, start_, kSmallestPivot);
    report.pivots += dictionary.pivots();
    return is_basis;
  };
  if (!load_into(small_)) return false;
  double smallest = 0.0, largest = 0.0, together = 0.0;
  for (int i = 0; i < size_; ++i) {
    const double w = small_.value(i), force = small_.value(size_ + i);
    smallest = std::min({smallest, w, force});
    largest = std::max({largest, w, force});
    together = std::max(together, std::min(w, force));
  }
  if (smallest < -1e-6 * largest || together > 1e-6 * largest) return false;
  load_into(dictionary_);
  take(lcp, report, lambda);
  return report.status == LcpStatus::kSolved;
}

/// In double, as the problem is given, from the basis without forces.
LcpStatus Lemke::attempt(const Lcp& lcp, int& pivots, Eigen::Ref<Eigen::VectorXd> lambda) noexcept {
  const int n = size_;
  const int z0 = 2 * n, rhs = 2 * n + 1;
  // w − F λ − 1 z0 = q
  tableau_.leftCols(n).setIdentity();
  tableau_.middleCols(n, n) = -lcp.F;
  tableau_.col(z0).setConstant(-1.0);
  tableau_.col(rhs) = lcp.q;
  for (int i = 0; i < n; ++i) basis_[i] = i;

  // z0 enters in the lexicographically smallest row; of equal q the last row has the smallest
  // [q | w columns], because the identity's 1 comes latest in it
  int row = 0;
  for (int i = 1; i < n; ++i) {
    if (tableau_(i, rhs) <= tableau_(row, rhs)) row = i;
  }
  int entering = z0;
  const int pivot_limit = 50 + 20 * n;
  while (true) {
    if (pivots == pivot_limit) return LcpStatus::kPivotLimit;
    const int leaving = basis_[row];
    pivot(row, entering);
    ++pivots;
    if (leaving == z0) break;
    entering = leaving < n ? leaving + n : leaving - n;  // the complement of what left
    row = leaving_row(entering);
    if (row < 0) return LcpStatus::kRay;
  }
  for (int i = 0; i < n; ++i) {
    if (basis_[i] >= n && basis_[i] < z0) lambda[basis_[i] - n] = std::max(tableau_(i, rhs), 0.0);
  }
  return LcpStatus::kSolved;
}

int Lemke::leaving_row(int entering) const noexcept {
  const int n = size_;
  const int z0 = 2 * n, rhs = 2 * n + 1;
  double largest = 0.0;
  for (int i = 0; i < n; ++i) largest = std::max(largest, std::abs(tableau_(i, entering)));
  const double smallest_pivot = kPivotTolerance * largest;

  // lexicographic comparison of [q | B⁻¹] rows over their pivots: is row i before row j?
  const auto before = [&](int i, int j) {
    const double a_i = tableau_(i, entering), a_j = tableau_(j, entering);
    const auto compare = [&](int column) {
      const double left = tableau_(i, column) / a_i, right = tableau_(j, column) / a_j;
      if (std::abs(left - right) <= kTieTolerance * std::max(std::abs(left), std::abs(right))) {
        return 0;
      }
      return left < right ? -1 : 1;
    };
    if (const int order = compare(rhs); order != 0) return order < 0;
    if (basis_[i] == z0 || basis_[j] == z0) return basis_[i] == z0;  // z0 leaves: solved
    for (int column = 0; column < n; ++column) {
      if (const int order = compare(column); order != 0) return order < 0;
    }
    return i < j;
  };

  int best = -1;
  for (int i = 0; i < n; ++i) {
    if (tableau_(i, entering) > smallest_pivot && (best < 0 || before(i, best))) best = i;
  }
  return best;
}

void Lemke::pivot(int row, int entering) noexcept {
  tableau_.row(row) /= tableau_(row, entering);
  for (int i = 0; i < size_; ++i) {
    if (i == row) continue;
    const double factor = tableau_(i, entering);
    if (factor == 0.0) continue;
    tableau_.row(i) -= factor * tableau_.row(row);
    tableau_(i, entering) = 0.0;
  }
  basis_[row] = entering;
}

}  // namespace c3rt::lcs
