#include "controller/lcs/dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace c3rt::lcs {
namespace {

double leading(double a) noexcept { return a; }
double leading(DoubleDouble a) noexcept { return a.high; }

// What is left of two numbers that cancel, beside them, where it is rounding alone. The data,
// doubles, differ by 1e-17 of themselves or not at all: in DoubleDouble the two cannot be confused.
template <typename Number>
constexpr double kCancelled = 8.0 * std::numeric_limits<double>::epsilon();
template <>
constexpr double kCancelled<DoubleDouble> = 1e-22;
// Ratios this close, beside each other, are a tie.
template <typename Number>
constexpr double kTie = 1e-12;
template <>
constexpr double kTie<DoubleDouble> = 1e-20;

/// a − b, exactly 0 where they are equal but for rounding.
template <typename Number>
Number subtract(const Number& a, const Number& b) noexcept {
  const Number difference = a - b;
  const double terms = std::abs(leading(a)) + std::abs(leading(b));
  return std::abs(leading(difference)) <= kCancelled<Number> * terms ? Number{} : difference;
}

}  // namespace

template <typename Number>
Dictionary<Number>::Dictionary(int size)
    : n_(size),
      entries_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size + 2)),
      basic_(size),
      other_(size + 1),
      where_(2 * size + 1),
      first_(size),
      rows_(size),
      columns_(size) {}

template <typename Number>
void Dictionary<Number>::load(const Eigen::Ref<const Eigen::MatrixXd>& F,
                              const Eigen::Ref<const Eigen::VectorXd>& q, const Eigen::VectorXd& R,
                              const Eigen::VectorXd& C, double epsilon) noexcept {
  pivots_ = 0;
  for (int i = 0; i < n_; ++i) {
    for (int j = 0; j < n_; ++j) at(i, j) = Number{-(R[i] * F(i, j) * C[j])};
    if (epsilon > 0.0) at(i, i) = at(i, i) - Number{epsilon};
    at(i, n_) = Number{-1.0};
    at(i, n_ + 1) = Number{R[i] * q[i]};
    basic_[i] = i;
    other_[i] = n_ + i;
    where_[i] = i;
    where_[n_ + i] = -1 - i;
  }
  other_[n_] = 2 * n_;
  where_[2 * n_] = -1 - n_;
}

template <typename Number>
bool Dictionary<Number>::exchange(const std::vector<char>& wanted, double smallest) noexcept {
  // λ_j's entry in the row of w_i, of pairs that are still to be exchanged
  const auto entry = [&](int i, int j) { return leading(at(where_[i], -1 - where_[n_ + j])); };
  const auto w_left = [&](int i) { return wanted[i] && is_basic(i); };
  // pairs and pairs of pairs: after each of them the basis is complementary
  while (true) {
    int first = -1, second = -1;
    double largest = smallest;
    for (int i = 0; i < n_; ++i) {
      if (!w_left(i)) continue;
      for (int j = 0; j <= i; ++j) {
        if (!w_left(j)) continue;
        const double size =
            i == j ? std::abs(entry(i, i))
                   : std::sqrt(std::abs(entry(i, j) * entry(j, i) - entry(i, i) * entry(j, j)));
        if (size <= largest) continue;
        largest = size;
        first = i;
        second = j;
      }
    }
    if (first < 0) break;
    if (std::abs(entry(first, second)) < std::abs(entry(second, first))) std::swap(first, second);
    pivot(where_[first], -1 - where_[n_ + second]);
    if (first != second) pivot(where_[second], -1 - where_[n_ + first]);
  }
  // the rest is complementary again only when all of it has been exchanged
  return exchange(wanted, wanted, smallest);
}

template <typename Number>
bool Dictionary<Number>::exchange(const std::vector<char>& leaving,
                                  const std::vector<char>& entering, double smallest) noexcept {
  const auto entry = [&](int i, int j) { return leading(at(where_[i], -1 - where_[n_ + j])); };
  const auto w_left = [&](int i) { return leaving[i] && is_basic(i); };
  const auto lambda_left = [&](int j) { return entering[j] && !is_basic(n_ + j); };
  int left = 0, exchanged = 0;
  for (int i = 0; i < n_; ++i) left += w_left(i);
  for (; exchanged < left; ++exchanged) {
    int row = -1, column = -1;
    double largest = smallest;
    for (int i = 0; i < n_; ++i) {
      if (!w_left(i)) continue;
      for (int j = 0; j < n_; ++j) {
        if (!lambda_left(j) || std::abs(entry(i, j)) <= largest) continue;
        largest = std::abs(entry(i, j));
        row = where_[i];
        column = -1 - where_[n_ + j];
      }
    }
    if (row < 0) break;
    rows_[exchanged] = row;
    columns_[exchanged] = column;
    pivot(row, column);
  }
  if (exchanged == left) return true;
  while (exchanged-- > 0) pivot(rows_[exchanged], columns_[exchanged]);
  return false;
}

template <typename Number>
void Dictionary<Number>::set_right_side(const std::vector<Number>& q) noexcept {
  for (int i = 0; i < n_; ++i) {
    Number sum{};
    for (int k = 0; k < n_; ++k) {
      const Number inverse = of_variable(i, k);  // the w columns hold B⁻¹
      if (leading(inverse) != 0.0) sum = sum + inverse * q[k];
    }
    at(i, n_ + 1) = sum;
  }
}

template <typename Number>
typename Dictionary<Number>::End Dictionary<Number>::cover(int pivot_limit,
                                                           double smallest) noexcept {
  const int z0 = 2 * n_;
  first_ = basic_;
  int column = -1 - where_[z0];
  for (int i = 0; i < n_; ++i) at(i, column) = Number{-1.0};
  // z0 enters in the lexicographically smallest row; of equal b the last, whose 1 of the identity
  // comes latest
  int row = 0;
  for (int i = 1; i < n_; ++i) {
    if (leading(subtract(at(i, n_ + 1), at(row, n_ + 1))) <= 0.0) row = i;
  }
  if (n_ == 0 || leading(at(row, n_ + 1)) >= 0.0) return End::kSolved;
  const int last = pivots_ + pivot_limit;
  while (pivots_ < last) {
    const int leaving = basic_[row];
    pivot(row, column);
    if (leaving == z0) return End::kSolved;
    // the complement of what left enters
    column = -1 - where_[leaving < n_ ? leaving + n_ : leaving - n_];
    double largest = 0.0;
    for (int i = 0; i < n_; ++i) largest = std::max(largest, std::abs(leading(at(i, column))));
    row = -1;
    for (int i = 0; i < n_; ++i) {
      const bool blocks = leading(at(i, column)) > smallest * largest;
      if (blocks && (row < 0 || before(i, row, column))) row = i;
    }
    if (row < 0) return End::kRay;
  }
  return End::kPivotLimit;
}

/// The entry of a row in the column of a variable that may be basic.
template <typename Number>
Number Dictionary<Number>::of_variable(int row, int variable) const noexcept {
  const int where = where_[variable];
  if (where < 0) return at(row, -1 - where);
  return Number{where == row ? 1.0 : 0.0};
}

/// Lexicographic comparison of [b | columns of the first basis], over the rows' pivots.
template <typename Number>
bool Dictionary<Number>::before(int i, int j, int column) const noexcept {
  const Number a_i = at(i, column), a_j = at(j, column);
  const auto compare = [&](const Number& of_i, const Number& of_j) {
    const Number left = of_i * a_j, right = of_j * a_i;
    const double difference = leading(left - right);
    const double terms = std::abs(leading(left)) + std::abs(leading(right));
    return std::abs(difference) <= kTie<Number> * terms ? 0 : difference < 0.0 ? -1 : 1;
  };
  if (const int order = compare(at(i, n_ + 1), at(j, n_ + 1)); order != 0) return order < 0;
  const int z0 = 2 * n_;
  if (basic_[i] == z0 || basic_[j] == z0) return basic_[i] == z0;  // z0 leaves: solved
  for (const int variable : first_) {
    const int order = compare(of_variable(i, variable), of_variable(j, variable));
    if (order != 0) return order < 0;
  }
  return i < j;
}

template <typename Number>
void Dictionary<Number>::pivot(int row, int column) noexcept {
  const Number inverse = Number{1.0} / at(row, column);
  for (int j = 0; j < n_ + 2; ++j) {
    if (j != column && leading(at(row, j)) != 0.0) at(row, j) = at(row, j) * inverse;
  }
  for (int i = 0; i < n_; ++i) {
    const Number factor = at(i, column);
    if (i == row || leading(factor) == 0.0) continue;
    for (int j = 0; j < n_ + 2; ++j) {
      if (j == column || leading(at(row, j)) == 0.0) continue;
      at(i, j) = subtract(at(i, j), factor * at(row, j));
    }
    at(i, column) = -(factor * inverse);
  }
  at(row, column) = inverse;
  std::swap(basic_[row], other_[column]);
  where_[basic_[row]] = row;
  where_[other_[column]] = -1 - column;
  ++pivots_;
}

template class Dictionary<double>;
template class Dictionary<DoubleDouble>;

}  // namespace c3rt::lcs
