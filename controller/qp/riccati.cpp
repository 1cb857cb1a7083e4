#include "controller/qp/riccati.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::qp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFirstShift = 1e-14;  // of the largest diagonal entry, where Cholesky breaks down
constexpr int kMaxShifts = 4;          // each 100 times the one before

constexpr double kRounding = 2.2e-16;
constexpr double kKnown = 1e-7;  // what rounding may leave open of the answer
constexpr double kOwn = 1e-6;    // share of a gradient's own terms that counts as its scale
constexpr int kInverseHessianStages = 2;  // that bring something; the sum stays linear in N

/// X += the rank_one_terms' rows [row, row + rows) and columns [column, column + columns), X with
/// columns `ld` apart.
void add_rank_one_terms(const RankOneTerms* rank_one_terms, int stage, int row, int rows,
                        int column, int columns, int ld, double* X) noexcept {
  if (rank_one_terms == nullptr) return;
  for (int i = rank_one_terms->first(stage); i >= 0; i = (*rank_one_terms)[i].next) {
    const RankOneTerms::Term& term = (*rank_one_terms)[i];
    if (term.coordinate >= 0) {
      const int r = term.coordinate - row, c = term.coordinate - column;
      if (r >= 0 && r < rows && c >= 0 && c < columns) X[c * ld + r] += term.weight;
      continue;
    }
    for (int c = 0; c < columns; ++c) {
      const double factor = term.weight * term.normal[column + c];
      if (factor == 0.0) continue;
      for (int r = 0; r < rows; ++r) X[c * ld + r] += factor * term.normal[row + r];
    }
  }
}

/// A maximum that keeps NaN.
double larger(double a, double b) noexcept { return a > b || std::isnan(a) ? a : b; }

}  // namespace

void RankOneTerms::prepare(int N, int terms) {
  first_.assign(static_cast<std::size_t>(N) + 1, -1);
  terms_.clear();
  terms_.reserve(static_cast<std::size_t>(terms));
}

void RankOneTerms::clear() noexcept {
  std::fill(first_.begin(), first_.end(), -1);
  terms_.clear();
}

void RankOneTerms::add(int stage, int coordinate, const double* normal, double weight) noexcept {
  terms_.push_back({coordinate, normal, weight, first_[stage]});
  first_[stage] = static_cast<int>(terms_.size()) - 1;
}

Riccati::Riccati(const Sizes& sizes)
    : sizes_(sizes),
      n_nu_(sizes.n_lambda + sizes.n_u),
      ld_x_(kernels::padded(sizes.n_x)),
      ld_nu_(kernels::padded(n_nu_)),
      ld_z_(kernels::padded(sizes.n_z())),
      systems_(sizes.N),
      stages_(sizes.N) {
  const auto n_x = static_cast<std::size_t>(sizes.n_x), n_nu = static_cast<std::size_t>(n_nu_);
  const auto ld_x = static_cast<std::size_t>(ld_x_), ld_nu = static_cast<std::size_t>(ld_nu_);
  const auto ld_z = static_cast<std::size_t>(ld_z_), N = static_cast<std::size_t>(sizes.N);
  const auto prepare = [n_x](Sparse& sparse, std::size_t columns) {
    sparse.start.assign(columns + 1, 0);
    sparse.row.assign(n_x * columns, 0);
    sparse.value.assign(n_x * columns, 0.0);
  };
  for (System& system : systems_) {
    prepare(system.A, n_x);
    prepare(system.B_hat, n_nu);
    system.next.assign(ld_x * (n_x + n_nu), 0.0);
    system.next_transposed.assign(ld_z * n_x, 0.0);
  }
  for (Stage& stage : stages_) {
    stage.L.assign(ld_nu * n_nu, 0.0);
    stage.L_inverse.assign(ld_nu, 0.0);
    stage.T.assign(ld_x * n_nu, 0.0);
    stage.P_next.assign(ld_x * n_x, 0.0);
    stage.kappa.assign(ld_nu, 0.0);
  }
  PA_.assign(ld_x * n_x, 0.0);
  AP_ = PA_;
  PB_.assign(ld_x * n_nu, 0.0);
  BP_.assign(ld_nu * n_x, 0.0);
  R_.assign(ld_nu * n_nu, 0.0);
  p_.assign(ld_x, 0.0);
  x_ = x_next_ = p_;
  nu_.assign(ld_nu, 0.0);
  z_.assign(ld_z, 0.0);
  terms_ = z_;
  dynamics_terms_.assign(ld_z * N, 0.0);
  left_ = dynamics_terms_;
  of_defects_.assign(N, 0.0);
  of_states_ = of_defects_;
}

void Riccati::start(Horizon lcs, bool lambda_0_fixed) noexcept {
  lcs_ = lcs;
  lambda_0_fixed_ = lambda_0_fixed;
  largest_gain_ = 0.0;
  const auto append = [](Sparse& sparse, int& column, const MatrixXd& M) {
    int entries = sparse.start[column];  // start[0] is 0 always
    for (Eigen::Index j = 0; j < M.cols(); ++j) {
      for (Eigen::Index i = 0; i < M.rows(); ++i) {
        if (M(i, j) == 0.0) continue;
        sparse.row[entries] = static_cast<int>(i);
        sparse.value[entries++] = M(i, j);
      }
      sparse.start[++column] = entries;
    }
  };
  for (int k = 0; k < (lcs.stride == 0 ? 1 : sizes_.N); ++k) {
    int column = 0;
    append(systems_[k].A, column, lcs[k].A);
    column = 0;
    append(systems_[k].B_hat, column, lcs[k].D);
    append(systems_[k].B_hat, column, lcs[k].B);
    double* next = systems_[k].next.data();
    for (const MatrixXd* M : {&lcs[k].A, &lcs[k].D, &lcs[k].B}) {
      for (Eigen::Index j = 0; j < M->cols(); ++j, next += ld_x_)
        std::copy_n(M->col(j).data(), sizes_.n_x, next);
    }
    kernels::transpose(sizes_.n_x, sizes_.n_z(), systems_[k].next.data(),
                       systems_[k].next_transposed.data());
    for (int e = 0; e < systems_[k].B_hat.start[n_nu_]; ++e) {
      largest_gain_ = std::max(largest_gain_, std::abs(systems_[k].B_hat.value[e]));
    }
  }
}

bool Riccati::factor(StageMatrices H, const MatrixXd& H_N, int last,
                     const RankOneTerms* rank_one_terms) noexcept {
  if (last >= sizes_.N) {
    last = sizes_.N - 1;
    std::vector<double>& P = stages_[last].P_next;
    for (int j = 0; j < sizes_.n_x; ++j) {
      std::copy_n(H_N.data() + j * sizes_.n_x, sizes_.n_x, &P[j * ld_x_]);
    }
    add_rank_one_terms(rank_one_terms, sizes_.N, 0, sizes_.n_x, 0, sizes_.n_x, ld_x_, P.data());
  }
  for (int k = last; k >= 0; --k) {
    if (!factor_inputs(k, H[k], rank_one_terms)) return false;
    if (k > 0) eliminate_inputs(k, H[k], rank_one_terms);
  }
  return true;
}

/// R̂ = H_νν + B̂ᵀ P B̂ and its factor. Where rounding makes it indefinite, a tiny shift makes it
/// definite; refinement with the exact gradient then removes the shift's error from a solution.
bool Riccati::factor_inputs(int k, const MatrixXd& H, const RankOneTerms* rank_one_terms) noexcept {
  const kernels::Columns B_hat = system(k).B_hat.columns();
  const int begin = first(k), n = n_nu_ - begin, n_x = sizes_.n_x, ld = kernels::padded(n);
  kernels::product(n_x, stages_[k].P_next.data(), B_hat, begin, n_nu_, PB_.data());
  kernels::transpose(n_x, n, PB_.data(), BP_.data());
  for (int j = 0; j < n; ++j) {
    std::copy_n(&H(n_x + begin, n_x + begin + j), n, &R_[j * ld]);
    std::fill(&R_[j * ld] + n, &R_[j * ld] + ld, 0.0);
  }
  add_rank_one_terms(rank_one_terms, k, n_x + begin, n, n_x + begin, n, ld, R_.data());
  kernels::add_product(n, BP_.data(), B_hat, begin, n_nu_, R_.data());
  Stage& stage = stages_[k];
  if (kernels::cholesky(n, R_.data(), stage.L.data(), stage.L_inverse.data())) return true;
  double shift = 0.0;
  for (int j = 0; j < n; ++j) shift = std::max(shift, kFirstShift * R_[j * ld + j]);
  for (int i = 0; i < kMaxShifts; ++i) {
    for (int j = 0; j < n; ++j) R_[j * ld + j] += shift;
    if (kernels::cholesky(n, R_.data(), stage.L.data(), stage.L_inverse.data())) return true;
    shift *= 100.0;
  }
  return false;
}

/// P_k = H_xx + Aᵀ P_{k+1} A − T Tᵀ with T = (L⁻¹ S)ᵀ.
void Riccati::eliminate_inputs(int k, const MatrixXd& H,
                               const RankOneTerms* rank_one_terms) noexcept {
  const System& system = this->system(k);
  const int n_x = sizes_.n_x;
  Stage& stage = stages_[k];
  std::vector<double>& P = stages_[k - 1].P_next;
  kernels::product(n_x, stage.P_next.data(), system.A.columns(), 0, n_x, PA_.data());
  kernels::transpose(n_x, n_x, PA_.data(), AP_.data());
  for (int j = 0; j < n_nu_; ++j) std::copy_n(&H(0, n_x + j), n_x, &stage.T[j * ld_x_]);
  add_rank_one_terms(rank_one_terms, k, 0, n_x, n_x, n_nu_, ld_x_, stage.T.data());
  kernels::add_product(n_x, AP_.data(), system.B_hat.columns(), 0, n_nu_, stage.T.data());
  kernels::solve_right(n_x, n_nu_, stage.L.data(), stage.L_inverse.data(), stage.T.data());
  for (int j = 0; j < n_x; ++j) std::copy_n(&H(0, j), n_x, &P[j * ld_x_]);
  add_rank_one_terms(rank_one_terms, k, 0, n_x, 0, n_x, ld_x_, P.data());
  kernels::add_product(n_x, AP_.data(), system.A.columns(), 0, n_x, P.data());
  kernels::subtract_gram(n_x, n_nu_, stage.T.data(), P.data());
  for (int j = 0; j < n_x; ++j) {
    for (int i = j + 1; i < n_x; ++i) P[i * ld_x_ + j] = P[j * ld_x_ + i];
  }
}

void Riccati::defects(const Eigen::Ref<const MatrixXd>& z, const Eigen::Ref<const VectorXd>& x_N,
                      MatrixXd& defect) const noexcept {
  const int n_x = sizes_.n_x, n_z = sizes_.n_z();
  for (int k = 0; k < sizes_.N; ++k) {
    const double* z_k = z.data() + k * z.outerStride();
    const double* x_next = k + 1 < sizes_.N ? z_k + z.outerStride() : x_N.data();
    kernels::minus_product(n_x, n_z, system(k).next.data(), ld_x_, z_k, lcs_[k].d.data(), x_next,
                           defect.data() + k * n_x);
  }
}

double Riccati::relative_defect(const Eigen::Ref<const MatrixXd>& z,
                                const Eigen::Ref<const VectorXd>& x_N,
                                const MatrixXd& defect) noexcept {
  const int n_x = sizes_.n_x, N = sizes_.N, stride = static_cast<int>(z.outerStride());
  kernels::largest_of_columns(n_x, N, defect.data(), n_x, of_defects_.data());
  kernels::largest_of_columns(n_x, N - 1, z.data() + stride, stride, of_states_.data());
  of_states_[N - 1] = kernels::largest(n_x, x_N.data());
  double worst = 0.0;
  for (int k = 0; k < N; ++k) {
    const double largest = of_defects_[k], of_next = of_states_[k];
    if (largest <= worst * of_next) continue;  // other terms could only make it less
    if (largest == 0.0) continue;
    std::copy_n(lcs_[k].d.data(), n_x, x_.data());
    kernels::add_columns(ld_x_, n_x, system(k).next.data(), ld_x_, z.data() + k * stride,
                         x_.data());
    worst = larger(worst, largest / std::max(kernels::largest(n_x, x_.data()), of_next));
  }
  return worst;
}

double Riccati::relative_step(const MatrixXd& step, const Eigen::Ref<const MatrixXd>& z) noexcept {
  const int n_z = sizes_.n_z(), stride = static_cast<int>(z.outerStride());
  kernels::largest_of_rows(n_z, sizes_.N, z.data(), stride, z_.data());
  kernels::largest_of_rows(n_z, sizes_.N, step.data(), n_z, terms_.data());
  double ratio = 0.0;
  const auto compare = [&](int first, int count) {
    double size = 0.0, change = 0.0;
    for (int i = first; i < first + count; ++i) {
      size = larger(size, z_[i]);
      change = larger(change, terms_[i]);
    }
    if (change > ratio * size) ratio = change / size;
  };
  compare(0, sizes_.n_x);
  compare(sizes_.n_x, sizes_.n_lambda);
  compare(sizes_.n_x + sizes_.n_lambda, sizes_.n_u);
  return ratio;
}

Riccati::Stationarity Riccati::stationarity(const MatrixXd& gradient, const VectorXd& gradient_N,
                                            const Eigen::Ref<const MatrixXd>& z) noexcept {
  return look(gradient, gradient_N, nullptr, z.data());
}

Riccati::Stationarity Riccati::stationarity_of_multipliers(const MatrixXd& gradient,
                                                           const VectorXd& gradient_N,
                                                           const MatrixXd& defect) noexcept {
  return look(gradient, gradient_N, &defect, nullptr);
}

Riccati::Stationarity Riccati::look(const MatrixXd& gradient, const VectorXd& gradient_N,
                                    const MatrixXd* defect, const double* z) noexcept {
  const int n_x = sizes_.n_x, n_z = sizes_.n_z();
  Stationarity found;
  std::copy_n(gradient_N.data(), n_x, p_.data());
  for (int k = sizes_.N - 1; k >= 0; --k) {
    const Stage& stage = stages_[k];
    const double* g = gradient.col(k).data();
    const int begin = first(k), n = n_nu_ - begin;
    if (defect != nullptr) {
      for (int i = 0; i < n_x; ++i) found.defect += p_[i] * (*defect)(i, k);
    }
    double* dynamics_term = &dynamics_terms_[k * ld_z_];
    double* left = &left_[k * ld_z_];
    kernels::product_and_terms(n_z, n_x, system(k).next_transposed.data(), p_.data(), dynamics_term,
                               terms_.data());
    double unknown[2] = {0.0, 0.0};  // of λ, of u
    for (int i = 0; i < n; ++i) {
      const int row = n_x + begin + i;
      left[row] = nu_[i] = dynamics_term[row] + g[row];
      // an entry of R̂⁻¹ is at least this
      double& kind = unknown[begin + i < sizes_.n_lambda ? 0 : 1];
      kind = std::max(kind, terms_[row] * stage.L_inverse[i] * stage.L_inverse[i]);
    }
    std::fill(nu_.begin() + n, nu_.end(), 0.0);
    if (z != nullptr) {
      const double* nu = z + k * n_z + n_x;
      const auto compare = [&found](double of_kind, int size, const double* values) {
        if (kRounding * of_kind <= kKnown) return;  // however small the values are
        const double largest = std::max(1.0, kernels::largest(size, values));
        if (!(kRounding * of_kind / largest <= kKnown)) found.is_known = false;
      };
      compare(unknown[0], sizes_.n_lambda, nu);
      compare(unknown[1], sizes_.n_u, nu + sizes_.n_lambda);
    } else {
      for (int i = 0; i < n; ++i) found.input_sum += std::abs(nu_[i]);
    }
    if (k == 0) break;
    kernels::solve_lower(n, stage.L.data(), stage.L_inverse.data(), nu_.data());
    std::fill(x_.begin(), x_.end(), 0.0);
    kernels::subtract_columns(n_x, n_nu_, stage.T.data(), nu_.data(), x_.data());
    for (int i = 0; i < n_x; ++i) {
      left[i] = x_[i];
      p_[i] = dynamics_term[i] + (g[i] + x_[i]);
    }
    if (z == nullptr) {
      for (int i = 0; i < n_x; ++i) found.state_sum += std::abs(x_[i]);
    }
  }
  // of the inputs of all stages, and of the states of those behind the first
  const auto of_inputs = [&](const double* v, int ld) {
    const int fixed = first(0);
    return larger(kernels::largest(n_nu_ - fixed, v + n_x + fixed),
                  kernels::largest(n_nu_, sizes_.N - 1, v + ld + n_x, ld));
  };
  const auto of_states = [&](const double* v, int ld) {
    return kernels::largest(n_x, sizes_.N - 1, v + ld, ld);
  };
  found.input_scale =
      larger(of_inputs(gradient.data(), n_z), of_inputs(dynamics_terms_.data(), ld_z_));
  found.input = of_inputs(left_.data(), ld_z_);
  found.state_scale =
      larger(of_states(gradient.data(), n_z), of_states(dynamics_terms_.data(), ld_z_));
  found.state = of_states(left_.data(), ld_z_);
  return found;
}

double Riccati::inverse_hessian_along(int k, const Eigen::Ref<const VectorXd>& a) noexcept {
  const int n_x = sizes_.n_x;
  std::fill(p_.begin(), p_.end(), 0.0);
  if (k == sizes_.N) std::copy_n(a.data(), n_x, p_.data());
  double sum = 0.0;
  int stages = 0;
  for (int j = std::min(k, sizes_.N - 1); j >= 0; --j) {
    const Stage& stage = stages_[j];
    const int begin = first(j), n = n_nu_ - begin;
    std::fill(z_.begin(), z_.end(), 0.0);
    if (j == k) std::copy_n(a.data(), sizes_.n_z(), z_.data());
    kernels::add_columns(ld_z_, n_x, system(j).next_transposed.data(), ld_z_, p_.data(), z_.data());
    std::fill(nu_.begin(), nu_.end(), 0.0);
    std::copy_n(&z_[n_x + begin], n, nu_.data());
    kernels::solve_lower(n, stage.L.data(), stage.L_inverse.data(), nu_.data());
    for (int i = 0; i < n; ++i) sum += nu_[i] * nu_[i];
    if (j == 0 || (sum > 0.0 && ++stages >= kInverseHessianStages)) break;
    std::copy_n(z_.data(), n_x, p_.data());
    kernels::subtract_columns(n_x, n_nu_, stage.T.data(), nu_.data(), p_.data());
  }
  return sum;
}

void Riccati::step(const MatrixXd& gradient, const VectorXd& gradient_N, const MatrixXd& defect,
                   MatrixXd& step_z, VectorXd& step_N) noexcept {
  const int n_x = sizes_.n_x;
  std::copy_n(gradient_N.data(), n_x, p_.data());
  for (int k = sizes_.N - 1; k >= 0; --k) {
    Stage& stage = stages_[k];
    const double* g = gradient.col(k).data();
    const int begin = first(k), n = n_nu_ - begin;
    // the cost-to-go is met at the state that the defect shifts
    kernels::subtract_columns(n_x, n_x, stage.P_next.data(), defect.col(k).data(), p_.data());
    std::copy_n(g, sizes_.n_z(), z_.data());
    kernels::add_columns(ld_z_, n_x, system(k).next_transposed.data(), ld_z_, p_.data(), z_.data());
    std::copy_n(&z_[n_x + begin], n, stage.kappa.data());
    kernels::solve_lower(n, stage.L.data(), stage.L_inverse.data(), stage.kappa.data());
    if (k == 0) break;
    std::copy_n(z_.data(), n_x, p_.data());
    kernels::subtract_columns(n_x, n_nu_, stage.T.data(), stage.kappa.data(), p_.data());
  }
  std::fill(x_.begin(), x_.end(), 0.0);
  for (int k = 0; k < sizes_.N; ++k) {
    const Stage& stage = stages_[k];
    const int begin = first(k), n = n_nu_ - begin;
    double* z_k = step_z.col(k).data();
    for (int i = 0; i < n; ++i) nu_[i] = -stage.kappa[i];
    if (k > 0) kernels::subtract_transposed(n_x, n_nu_, stage.T.data(), x_.data(), nu_.data());
    kernels::solve_lower_transposed(n, stage.L.data(), stage.L_inverse.data(), nu_.data());
    std::copy_n(x_.data(), n_x, z_k);
    std::fill_n(z_k + n_x, begin, 0.0);
    std::copy_n(nu_.data(), n, z_k + n_x + begin);
    for (int i = 0; i < n_x; ++i) x_next_[i] = -defect(i, k);
    kernels::add_columns(ld_x_, sizes_.n_z(), system(k).next.data(), ld_x_, z_k, x_next_.data());
    x_.swap(x_next_);
  }
  std::copy_n(x_.data(), n_x, step_N.data());
}

double relative(const Riccati::Stationarity& found, const QpCost::Terms& terms,
                double gain) noexcept {
  // terms of the gradient in the inputs count where nothing else is there, to cover their rounding
  const double input_scale = std::max({found.input_scale, gain * terms.state, kOwn * terms.input});
  const double state_scale = std::max(found.state_scale, terms.state);
  const double input = found.input == 0.0 ? 0.0 : found.input / input_scale;
  return larger(input, found.state == 0.0 ? 0.0 : found.state / state_scale);
}

}  // namespace c3rt::qp
