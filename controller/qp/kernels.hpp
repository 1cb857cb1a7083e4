#pragma once

/// Small dense kernels of the Riccati recursion, on raw column-major arrays whose columns are
/// padded with zeros to `padded(rows)`. Every element is summed in one fixed order whatever the
/// width of the machine's vectors, so that the bits are the same everywhere. RT: no heap, no lock,
/// no throw.
namespace c3rt::qp::kernels {

/// Rows are handled in fours.
constexpr int padded(int rows) noexcept { return (rows + 3) / 4 * 4; }

/// A matrix by columns, zeros left out: entries start[j] … start[j+1]−1 are those of column j.
struct Columns {
  const int* start;
  const int* row;
  const double* value;
};

/// Y += X S for columns [first, last) of S, those of Y from 0 on. X (rows × …).
void add_product(int rows, const double* X, Columns S, int first, int last, double* Y) noexcept;

/// Y = X S in the same way.
void product(int rows, const double* X, Columns S, int first, int last, double* Y) noexcept;

/// Y = Xᵀ, X (rows × cols).
void transpose(int rows, int cols, const double* X, double* Y) noexcept;

/// L Lᵀ = X for the lower triangle of X (n × n); inverse[j] = 1/L_jj. False if a pivot is not
/// positive. X and L may be the same.
bool cholesky(int n, const double* X, double* L, double* inverse) noexcept;

/// Y Lᵀ = Y in place, Y (rows × n).
void solve_right(int rows, int n, const double* L, const double* inverse, double* Y) noexcept;

/// X −= Y Yᵀ, lower triangle of X (rows × rows), Y (rows × n).
void subtract_gram(int rows, int n, const double* Y, double* X) noexcept;

/// y += X c, X (rows × cols) with columns `stride` apart, nothing padded.
void add_columns(int rows, int cols, const double* X, int stride, const double* c,
                 double* y) noexcept;

/// c −= Xᵀ y, X (rows × cols), y padded.
void subtract_transposed(int rows, int cols, const double* X, const double* y, double* c) noexcept;

/// y −= X c, X (rows × cols), y padded.
void subtract_columns(int rows, int cols, const double* X, const double* c, double* y) noexcept;

/// y = X c and terms = |X| |c|, X (rows × cols), y and terms padded.
void product_and_terms(int rows, int cols, const double* X, const double* c, double* y,
                       double* terms) noexcept;

/// y = X c − b, X (rows × cols) with columns `stride` apart, nothing padded.
void product_minus(int rows, int cols, const double* X, int stride, const double* c,
                   const double* b, double* y) noexcept;

/// y = b − (a + X c) in the same way.
void minus_product(int rows, int cols, const double* X, int stride, const double* c,
                   const double* a, const double* b, double* y) noexcept;

/// The largest |X_ij|, X (rows × cols) with columns `stride` apart, nothing padded; NaN if one is
/// not finite.
double largest(int rows, int cols, const double* X, int stride) noexcept;
inline double largest(int n, const double* v) noexcept { return largest(n, 1, v, n); }
/// The same of each column, and of each row.
void largest_of_columns(int rows, int cols, const double* X, int stride, double* out) noexcept;
void largest_of_rows(int rows, int cols, const double* X, int stride, double* out) noexcept;

/// L⁻¹ y in place, y padded.
void solve_lower(int n, const double* L, const double* inverse, double* y) noexcept;

/// L⁻ᵀ y in place; y is padded with zeros.
void solve_lower_transposed(int n, const double* L, const double* inverse, double* y) noexcept;

}  // namespace c3rt::qp::kernels
