#include "controller/qp/kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

// Compiled a second time with wider vectors where the processor has them. Without fused
// multiply-add an element sees the same operations in the same order either way. Sanitizers cannot
// follow.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define C3RT_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define C3RT_WIDE
#endif
#define C3RT_INLINE inline __attribute__((always_inline))

namespace c3rt::qp::kernels {
namespace {

using Four __attribute__((vector_size(32))) = double;
using FourAnywhere __attribute__((vector_size(32), aligned(8), may_alias)) = double;
using FourBits __attribute__((vector_size(32))) = long long;
using FourBitsAnywhere __attribute__((vector_size(32), aligned(8), may_alias)) = long long;

constexpr int kMaxFours = 6;  // that many sums fit the registers

/// y ±= Σ_m c[m stride] X[:, column m], or with kFromZero y = that, over 4 kFours rows; column m is
/// index[m] or m itself.
template <int kFours, bool kSubtract, bool kIndexed, bool kFromZero = false>
C3RT_INLINE void accumulate_fours(const double* X, int ld, int count, const int* index,
                                  const double* c, int stride, double* y) {
  Four sum[kFours];
  for (int i = 0; i < kFours; ++i) {
    if (kFromZero) {
      sum[i] = Four{0.0, 0.0, 0.0, 0.0};
    } else {
      sum[i] = *reinterpret_cast<const FourAnywhere*>(y + 4 * i);
    }
  }
  for (int m = 0; m < count; ++m) {
    const double* x = X + static_cast<long>(kIndexed ? index[m] : m) * ld;
    const double factor = kSubtract ? -c[static_cast<long>(m) * stride] : c[m * stride];
    const Four factors = {factor, factor, factor, factor};
    for (int i = 0; i < kFours; ++i) {
      sum[i] += factors * *reinterpret_cast<const FourAnywhere*>(x + 4 * i);
    }
  }
  for (int i = 0; i < kFours; ++i) *reinterpret_cast<FourAnywhere*>(y + 4 * i) = sum[i];
}

template <bool kSubtract>
C3RT_INLINE void accumulate(int rows, const double* X, int ld, int count, const double* c,
                            int stride, double* y) {
  if (count == 0) return;  // X may be null then
  for (int left = rows / 4; left > 0;) {
    const int fours = std::min(left, kMaxFours);
    switch (fours) {
      case 1:
        accumulate_fours<1, kSubtract, false>(X, ld, count, nullptr, c, stride, y);
        break;
      case 2:
        accumulate_fours<2, kSubtract, false>(X, ld, count, nullptr, c, stride, y);
        break;
      case 3:
        accumulate_fours<3, kSubtract, false>(X, ld, count, nullptr, c, stride, y);
        break;
      case 4:
        accumulate_fours<4, kSubtract, false>(X, ld, count, nullptr, c, stride, y);
        break;
      case 5:
        accumulate_fours<5, kSubtract, false>(X, ld, count, nullptr, c, stride, y);
        break;
      default:
        accumulate_fours<6, kSubtract, false>(X, ld, count, nullptr, c, stride, y);
        break;
    }
    X += 4 * fours;
    y += 4 * fours;
    left -= fours;
  }
}

/// Y += X S, or with kFromZero Y = X S, for 4 kFours of the rows.
template <int kFours, bool kFromZero>
C3RT_INLINE void add_fours(const double* X, int ld, Columns S, int first, int last, double* Y) {
  for (int j = first; j < last; ++j, Y += ld) {
    const int begin = S.start[j];
    accumulate_fours<kFours, false, true, kFromZero>(X, ld, S.start[j + 1] - begin, S.row + begin,
                                                     S.value + begin, 1, Y);
  }
}

template <bool kFromZero>
C3RT_INLINE void multiply(int rows, const double* X, Columns S, int first, int last, double* Y) {
  const int ld = padded(rows);
  for (int row = 0, left = ld / 4; left > 0; row += 4 * kMaxFours, left -= kMaxFours) {
    const double* x = X + row;
    double* y = Y + row;
    switch (std::min(left, kMaxFours)) {
      case 1:
        add_fours<1, kFromZero>(x, ld, S, first, last, y);
        break;
      case 2:
        add_fours<2, kFromZero>(x, ld, S, first, last, y);
        break;
      case 3:
        add_fours<3, kFromZero>(x, ld, S, first, last, y);
        break;
      case 4:
        add_fours<4, kFromZero>(x, ld, S, first, last, y);
        break;
      case 5:
        add_fours<5, kFromZero>(x, ld, S, first, last, y);
        break;
      default:
        add_fours<6, kFromZero>(x, ld, S, first, last, y);
        break;
    }
  }
}

/// Four rows are transposed.
C3RT_INLINE void turn(Four (&rows)[4]) {
  const Four ab_even = __builtin_shufflevector(rows[0], rows[1], 0, 4, 2, 6);
  const Four ab_odd = __builtin_shufflevector(rows[0], rows[1], 1, 5, 3, 7);
  const Four cd_even = __builtin_shufflevector(rows[2], rows[3], 0, 4, 2, 6);
  const Four cd_odd = __builtin_shufflevector(rows[2], rows[3], 1, 5, 3, 7);
  rows[0] = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  rows[1] = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  rows[2] = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  rows[3] = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
}

/// L⁻¹ y of a triangle so small that its loops are unrolled, and L⁻ᵀ y.
template <int kSize>
C3RT_INLINE void solve_small(const double* L, int ld, const double* inverse, double* y) {
  for (int m = 0; m < kSize; ++m) {
    y[m] *= inverse[m];
    for (int i = m + 1; i < kSize; ++i) y[i] -= L[m * ld + i] * y[m];
  }
}
template <int kSize>
C3RT_INLINE void solve_small_transposed(const double* L, int ld, const double* inverse, double* y) {
  for (int m = kSize - 1; m >= 0; --m) {
    y[m] *= inverse[m];
    for (int i = 0; i < m; ++i) y[i] -= L[i * ld + m] * y[m];
  }
}

/// Four rows from each of `at` on: side by side, as one sum alone waits for each of its terms.
template <int kFours, bool kMinusB>
C3RT_INLINE void combine_fours(const int (&at)[kFours], int cols, const double* X, int stride,
                               const double* c, const double* a, const double* b, double* y) {
  Four sums[kFours];
  for (int m = 0; m < kFours; ++m) {
    sums[m] =
        a == nullptr ? Four{0.0, 0.0, 0.0, 0.0} : *reinterpret_cast<const FourAnywhere*>(a + at[m]);
  }
  for (int j = 0; j < cols; ++j, X += stride) {
    const Four factors = {c[j], c[j], c[j], c[j]};
    for (int m = 0; m < kFours; ++m)
      sums[m] += factors * *reinterpret_cast<const FourAnywhere*>(X + at[m]);
  }
  for (int m = 0; m < kFours; ++m) {
    const Four other = *reinterpret_cast<const FourAnywhere*>(b + at[m]);
    *reinterpret_cast<FourAnywhere*>(y + at[m]) = kMinusB ? sums[m] - other : other - sums[m];
  }
}

/// y = a + X c − b, or b − (a + X c); no a is zeros.
template <bool kMinusB>
C3RT_INLINE void combine(int rows, int cols, const double* X, int stride, const double* c,
                         const double* a, const double* b, double* y) {
  if (rows < 4) {
    for (int i = 0; i < rows; ++i) {
      double sum = a == nullptr ? 0.0 : a[i];
      for (int j = 0; j < cols; ++j) sum += X[static_cast<long>(j) * stride + i] * c[j];
      y[i] = kMinusB ? sum - b[i] : b[i] - sum;
    }
    return;
  }
  // the last four may overlap those before; the same rows twice are the same again
  const int last = rows - 4;
  int i = 0;
  for (; rows - i > 12; i += 16) {
    const int at[] = {i, std::min(i + 4, last), std::min(i + 8, last), std::min(i + 12, last)};
    combine_fours<4, kMinusB>(at, cols, X, stride, c, a, b, y);
  }
  for (; rows - i > 4; i += 8) {
    const int at[] = {i, std::min(i + 4, last)};
    combine_fours<2, kMinusB>(at, cols, X, stride, c, a, b, y);
  }
  if (i < rows) combine_fours<1, kMinusB>({std::min(i, last)}, cols, X, stride, c, a, b, y);
}

constexpr long long kSize = std::numeric_limits<long long>::max();  // all but a double's sign

C3RT_INLINE double finite_or_nan(long long bits) {
  double value;
  std::memcpy(&value, &bits, sizeof value);
  return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

/// 4 kFours rows of y = X c and terms = |X| |c|, side by side.
template <int kFours>
C3RT_INLINE void product_and_terms_of(int ld, int cols, const double* X, const double* c, double* y,
                                      double* terms) {
  Four sums[kFours] = {}, sizes[kFours] = {};
  for (int j = 0; j < cols; ++j, X += ld) {
    const Four factors = {c[j], c[j], c[j], c[j]};
    for (int m = 0; m < kFours; ++m) {
      const Four term = factors * *reinterpret_cast<const FourAnywhere*>(X + 4 * m);
      sums[m] += term;
      sizes[m] += reinterpret_cast<Four>(kSize & reinterpret_cast<FourBits>(term));
    }
  }
  for (int m = 0; m < kFours; ++m) {
    *reinterpret_cast<FourAnywhere*>(y + 4 * m) = sums[m];
    *reinterpret_cast<FourAnywhere*>(terms + 4 * m) = sizes[m];
  }
}

/// A maximum of sizes: without their signs, doubles are in the order of their bits, and NaN is
/// above infinity.
struct Largest {
  FourBits most = {0, 0, 0, 0};
  long long all = 0;

  C3RT_INLINE void add(int rows, const double* X) {
    if (rows >= 4) {
      for (int i = 0; i < rows; i += 4) {  // the last four may overlap those before
        const FourBits bits =
            kSize & *reinterpret_cast<const FourBitsAnywhere*>(X + std::min(i, rows - 4));
        most = bits > most ? bits : most;
      }
    } else {
      for (int i = 0; i < rows; ++i) {
        long long bits;
        std::memcpy(&bits, X + i, sizeof bits);
        all = std::max(all, bits & kSize);
      }
    }
  }
  C3RT_INLINE double value() const {
    long long result = all;
    for (int i = 0; i < 4; ++i) result = std::max<long long>(result, most[i]);
    return finite_or_nan(result);
  }
};

/// The row from which column j of a symmetric matrix is computed.
C3RT_INLINE int from_row(int j) { return j / 4 * 4; }

}  // namespace

C3RT_WIDE void add_product(int rows, const double* X, Columns S, int first, int last,
                           double* Y) noexcept {
  multiply<false>(rows, X, S, first, last, Y);
}

C3RT_WIDE void product(int rows, const double* X, Columns S, int first, int last,
                       double* Y) noexcept {
  multiply<true>(rows, X, S, first, last, Y);
}

C3RT_WIDE void transpose(int rows, int cols, const double* X, double* Y) noexcept {
  const int ld_X = padded(rows), ld_Y = padded(cols);
  const Four zeros = {0.0, 0.0, 0.0, 0.0};  // in Y's padding
  for (int j = 0; j < rows; j += 4) {       // X is padded, Y has `rows` columns
    for (int i = 0; i < cols; i += 4) {
      const double* x = X + i * ld_X + j;
      const int left = cols - i;
      const Four a = *reinterpret_cast<const FourAnywhere*>(x);
      const Four b = left > 1 ? *reinterpret_cast<const FourAnywhere*>(x + ld_X) : zeros;
      const Four c = left > 2 ? *reinterpret_cast<const FourAnywhere*>(x + 2 * ld_X) : zeros;
      const Four d = left > 3 ? *reinterpret_cast<const FourAnywhere*>(x + 3 * ld_X) : zeros;
      Four row[4] = {a, b, c, d};
      turn(row);
      for (int m = 0; m < 4 && j + m < rows; ++m) {
        *reinterpret_cast<FourAnywhere*>(Y + (j + m) * ld_Y + i) = row[m];
      }
    }
  }
}

C3RT_WIDE bool cholesky(int n, const double* X, double* L, double* inverse) noexcept {
  const int ld = padded(n);
  for (int j = 0; j < n; ++j) {
    const int from = from_row(j);
    double* column = L + j * ld;
    if (X != L) std::copy(X + j * ld + from, X + (j + 1) * ld, column + from);
    accumulate<true>(ld - from, L + from, ld, j, L + j, ld, column + from);
    if (!(column[j] > 0.0)) return false;
    const double root = std::sqrt(column[j]);
    inverse[j] = 1.0 / root;
    for (int i = j + 1; i < n; ++i) column[i] *= inverse[j];
    column[j] = root;
  }
  return true;
}

C3RT_WIDE void solve_right(int rows, int n, const double* L, const double* inverse,
                           double* Y) noexcept {
  const int ld = padded(rows), ld_L = padded(n);
  for (int j = 0; j < n; ++j) {
    double* column = Y + j * ld;
    accumulate<true>(ld, Y, ld, j, L + j, ld_L, column);
    for (int i = 0; i < ld; ++i) column[i] *= inverse[j];
  }
}

C3RT_WIDE void subtract_gram(int rows, int n, const double* Y, double* X) noexcept {
  const int ld = padded(rows);
  for (int j = 0; j < rows; ++j) {
    const int from = from_row(j);
    accumulate<true>(ld - from, Y + from, ld, n, Y + j, ld, X + j * ld + from);
  }
}

C3RT_WIDE void add_columns(int rows, int cols, const double* X, int stride, const double* c,
                           double* y) noexcept {
  const int whole = rows / 4 * 4;
  if (whole == 0) {
    for (int i = 0; i < rows; ++i) {
      double sum = y[i];
      for (int j = 0; j < cols; ++j) sum += X[static_cast<long>(j) * stride + i] * c[j];
      y[i] = sum;
    }
    return;
  }
  // the last four beside the others: some are summed twice
  Four last = *reinterpret_cast<const FourAnywhere*>(y + rows - 4);
  if (whole < rows) {
    const double* x = X + rows - 4;
    for (int j = 0; j < cols; ++j, x += stride) {
      const Four factors = {c[j], c[j], c[j], c[j]};
      last += factors * *reinterpret_cast<const FourAnywhere*>(x);
    }
  }
  accumulate<false>(whole, X, stride, cols, c, 1, y);
  if (whole < rows) *reinterpret_cast<FourAnywhere*>(y + rows - 4) = last;
}

C3RT_WIDE void subtract_columns(int rows, int cols, const double* X, const double* c,
                                double* y) noexcept {
  const int ld = padded(rows);
  accumulate<true>(ld, X, ld, cols, c, 1, y);
}

C3RT_WIDE void subtract_transposed(int rows, int cols, const double* X, const double* y,
                                   double* c) noexcept {
  const int ld = padded(rows);
  for (int j = 0; j < cols; ++j) {
    Four sum = {0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i < ld; i += 4) {
      sum += *reinterpret_cast<const FourAnywhere*>(X + j * ld + i) *
             *reinterpret_cast<const FourAnywhere*>(y + i);
    }
    c[j] -= (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
}

C3RT_WIDE void product_and_terms(int rows, int cols, const double* X, const double* c, double* y,
                                 double* terms) noexcept {
  const int ld = padded(rows);
  int i = 0;
  for (; i + 8 < ld; i += 12) product_and_terms_of<3>(ld, cols, X + i, c, y + i, terms + i);
  for (; i < ld; i += 4) product_and_terms_of<1>(ld, cols, X + i, c, y + i, terms + i);
}

C3RT_WIDE void product_minus(int rows, int cols, const double* X, int stride, const double* c,
                             const double* b, double* y) noexcept {
  combine<true>(rows, cols, X, stride, c, nullptr, b, y);
}

C3RT_WIDE void minus_product(int rows, int cols, const double* X, int stride, const double* c,
                             const double* a, const double* b, double* y) noexcept {
  combine<false>(rows, cols, X, stride, c, a, b, y);
}

C3RT_WIDE double largest(int rows, int cols, const double* X, int stride) noexcept {
  Largest most;
  for (int j = 0; j < cols; ++j, X += stride) most.add(rows, X);
  return most.value();
}

C3RT_WIDE void largest_of_columns(int rows, int cols, const double* X, int stride,
                                  double* out) noexcept {
  for (int j = 0; j < cols; ++j, X += stride) {
    Largest most;
    most.add(rows, X);
    out[j] = most.value();
  }
}

C3RT_WIDE void largest_of_rows(int rows, int cols, const double* X, int stride,
                               double* out) noexcept {
  if (rows < 4) {
    for (int i = 0; i < rows; ++i) {
      Largest most;
      for (int j = 0; j < cols; ++j) most.add(1, X + static_cast<long>(j) * stride + i);
      out[i] = most.value();
    }
    return;
  }
  for (int i = 0; i < rows; i += 4) {
    const int at = std::min(i, rows - 4);
    FourBits most = {0, 0, 0, 0};
    for (int j = 0; j < cols; ++j) {
      const FourBits bits = kSize & *reinterpret_cast<const FourBitsAnywhere*>(
                                        X + static_cast<long>(j) * stride + at);
      most = bits > most ? bits : most;
    }
    for (int m = 0; m < 4; ++m) out[at + m] = finite_or_nan(most[m]);
  }
}

C3RT_WIDE void solve_lower(int n, const double* L, const double* inverse, double* y) noexcept {
  const int ld = padded(n);
  for (; n >= 4; n -= 4, L += 4 * ld + 4, inverse += 4, y += 4) {
    solve_small<4>(L, ld, inverse, y);
    for (int i = 4; i < padded(n); i += 4) {
      accumulate_fours<1, true, false>(L + i, ld, 4, nullptr, y, 1, y + i);
    }
  }
  if (n == 3) solve_small<3>(L, ld, inverse, y);
  if (n == 2) solve_small<2>(L, ld, inverse, y);
  if (n == 1) solve_small<1>(L, ld, inverse, y);
}

C3RT_WIDE void solve_lower_transposed(int n, const double* L, const double* inverse,
                                      double* y) noexcept {
  const int ld = padded(n);
  for (int j = ld - 4; j >= 0; j -= 4) {
    const double* corner = L + j * ld + j;
    if (n - j >= 4) solve_small_transposed<4>(corner, ld, inverse + j, y + j);
    if (n - j == 3) solve_small_transposed<3>(corner, ld, inverse + j, y + j);
    if (n - j == 2) solve_small_transposed<2>(corner, ld, inverse + j, y + j);
    if (n - j == 1) solve_small_transposed<1>(corner, ld, inverse + j, y + j);
    for (int i = 0; i < j; i += 4) {
      Four rows[4], sum = *reinterpret_cast<const FourAnywhere*>(y + i);
      for (int m = 0; m < 4; ++m) {
        rows[m] = *reinterpret_cast<const FourAnywhere*>(L + (i + m) * ld + j);
      }
      turn(rows);
      for (int m = 3; m >= 0; --m) {
        sum -= rows[m] * Four{y[j + m], y[j + m], y[j + m], y[j + m]};
      }
      *reinterpret_cast<FourAnywhere*>(y + i) = sum;
    }
  }
}

}  // namespace c3rt::qp::kernels
