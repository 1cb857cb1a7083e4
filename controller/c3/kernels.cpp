#include "controller/c3/kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

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

namespace c3rt::c3::kernels {
namespace {

typedef double Four __attribute__((vector_size(32)));

constexpr int kMaxFours = 6;  // that many sums fit the registers

/// y ±= Σ_m c[m stride] X[:, column m], over 4 kFours rows; column m is index[m] or m itself.
template <int kFours, bool kSubtract, bool kIndexed>
C3RT_INLINE void accumulate_fours(const double* X, int ld, int count, const int* index,
                                  const double* c, int stride, double* y) {
  Four sum[kFours];
  std::memcpy(sum, y, sizeof sum);
  for (int m = 0; m < count; ++m) {
    const double* x = X + static_cast<long>(kIndexed ? index[m] : m) * ld;
    const double factor = kSubtract ? -c[static_cast<long>(m) * stride] : c[m * stride];
    const Four factors = {factor, factor, factor, factor};
    for (int i = 0; i < kFours; ++i) {
      Four column;
      std::memcpy(&column, x + 4 * i, sizeof column);
      sum[i] += factors * column;
    }
  }
  std::memcpy(y, sum, sizeof sum);
}

template <bool kSubtract, bool kIndexed>
C3RT_INLINE void accumulate(int rows, const double* X, int ld, int count, const int* index,
                            const double* c, int stride, double* y) {
  for (int left = rows / 4; left > 0;) {
    const int fours = std::min(left, kMaxFours);
    switch (fours) {
      case 1:
        accumulate_fours<1, kSubtract, kIndexed>(X, ld, count, index, c, stride, y);
        break;
      case 2:
        accumulate_fours<2, kSubtract, kIndexed>(X, ld, count, index, c, stride, y);
        break;
      case 3:
        accumulate_fours<3, kSubtract, kIndexed>(X, ld, count, index, c, stride, y);
        break;
      case 4:
        accumulate_fours<4, kSubtract, kIndexed>(X, ld, count, index, c, stride, y);
        break;
      case 5:
        accumulate_fours<5, kSubtract, kIndexed>(X, ld, count, index, c, stride, y);
        break;
      default:
        accumulate_fours<6, kSubtract, kIndexed>(X, ld, count, index, c, stride, y);
        break;
    }
    X += 4 * fours;
    y += 4 * fours;
    left -= fours;
  }
}

/// The row from which column j of a symmetric matrix is computed.
C3RT_INLINE int from_row(int j) { return j / 4 * 4; }

}  // namespace

C3RT_WIDE void add_product(int rows, const double* X, Columns S, int first, int last, bool triangle,
                           double* Y) noexcept {
  const int ld = padded(rows);
  for (int j = first; j < last; ++j) {
    const int from = triangle ? from_row(j - first) : 0, begin = S.start[j];
    accumulate<false, true>(ld - from, X + from, ld, S.start[j + 1] - begin, S.row + begin,
                            S.value + begin, 1, Y + (j - first) * ld + from);
  }
}

void transpose(int rows, int cols, const double* X, double* Y) noexcept {
  const int ld_X = padded(rows), ld_Y = padded(cols);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < cols; ++i) Y[j * ld_Y + i] = X[i * ld_X + j];
  }
}

C3RT_WIDE bool cholesky(int n, const double* X, double* L, double* inverse) noexcept {
  const int ld = padded(n);
  for (int j = 0; j < n; ++j) {
    const int from = from_row(j);
    double* column = L + j * ld;
    if (X != L) std::copy(X + j * ld + from, X + (j + 1) * ld, column + from);
    accumulate<true, false>(ld - from, L + from, ld, j, nullptr, L + j, ld, column + from);
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
    accumulate<true, false>(ld, Y, ld, j, nullptr, L + j, ld_L, column);
    for (int i = 0; i < ld; ++i) column[i] *= inverse[j];
  }
}

C3RT_WIDE void subtract_gram(int rows, int n, const double* Y, double* X) noexcept {
  const int ld = padded(rows);
  for (int j = 0; j < rows; ++j) {
    const int from = from_row(j);
    accumulate<true, false>(ld - from, Y + from, ld, n, nullptr, Y + j, ld, X + j * ld + from);
  }
}

C3RT_WIDE void add_columns(int rows, int cols, const double* X, int stride, const double* c,
                           double* y) noexcept {
  const int whole = rows / 4 * 4;
  accumulate<false, false>(whole, X, stride, cols, nullptr, c, 1, y);
  for (int i = whole; i < rows; ++i) {
    double sum = y[i];
    for (int j = 0; j < cols; ++j) sum += X[static_cast<long>(j) * stride + i] * c[j];
    y[i] = sum;
  }
}

C3RT_WIDE void subtract_columns(int rows, int cols, const double* X, const double* c,
                                double* y) noexcept {
  const int ld = padded(rows);
  accumulate<true, false>(ld, X, ld, cols, nullptr, c, 1, y);
}

C3RT_WIDE void subtract_transposed(int rows, int cols, const double* X, const double* y,
                                   double* c) noexcept {
  const int ld = padded(rows);
  for (int j = 0; j < cols; ++j) {
    Four sum = {0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i < ld; i += 4) {
      Four a, b;
      std::memcpy(&a, X + j * ld + i, sizeof a);
      std::memcpy(&b, y + i, sizeof b);
      sum += a * b;
    }
    c[j] -= (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
}

void solve_lower(int n, const double* L, const double* inverse, double* y) noexcept {
  const int ld = padded(n);
  for (int j = 0; j < n; ++j) {
    y[j] *= inverse[j];
    for (int i = j + 1; i < n; ++i) y[i] -= L[j * ld + i] * y[j];
  }
}

void solve_lower_transposed(int n, const double* L, const double* inverse, double* y) noexcept {
  const int ld = padded(n);
  for (int j = n - 1; j >= 0; --j) {
    y[j] *= inverse[j];
    for (int i = 0; i < j; ++i) y[i] -= L[i * ld + j] * y[j];
  }
}

}  // namespace c3rt::c3::kernels
