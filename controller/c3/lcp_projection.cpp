#include <cmath>

#include "controller/c3/projection.hpp"
#include "controller/lcs/lemke.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::VectorXd;

constexpr double kInSet = 1e-9;           // of the terms of a gap
constexpr double kForceRounding = 1e-12;  // of the largest force: what a force of 0 may be instead

class LcpProjection final : public Projection {
 public:
  explicit LcpProjection(const Sizes& sizes)
      : sizes_(sizes), lemke_(sizes.n_lambda), difference_(sizes.n_z()), weighted_(sizes.n_z()) {}

  void set_weights(const Costs& costs) override { U_ = costs.U; }

  void start(const lcs::Lcs& lcs) noexcept override { lcs_ = &lcs; }

  ProjectionReport project(const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> delta,
                           const Deadline&) noexcept override {
    delta = v;
    if (!v.allFinite()) return {ProjectionStatus::kNotFinite, 0, 0.0};
    VectorXd& q = lemke_.q();
    q = lcs_->c;
    q.noalias() += lcs_->E * sizes_.x(v);
    q.noalias() += lcs_->H * sizes_.u(v);
    const lcs::LcpReport lcp = lemke_.solve_regularised(lcs_->F, q, sizes_.lambda(delta));
    if (lcp.status != lcs::LcpStatus::kSolved) {
      delta = v;
      return {lcp.status == lcs::LcpStatus::kInaccurate ? ProjectionStatus::kInaccurate
                                                        : ProjectionStatus::kNotFound,
              lcp.pivots, 0.0};
    }
    if (!is_in_set(q, sizes_.lambda(delta), v)) {
      delta = v;
      return {ProjectionStatus::kNotFound, lcp.pivots, 0.0};
    }
    difference_ = delta - v;
    if (U_.size() == 0) return {ProjectionStatus::kSolved, lcp.pivots, difference_.squaredNorm()};
    weighted_.noalias() = U_ * difference_;
    return {ProjectionStatus::kSolved, lcp.pivots, difference_.dot(weighted_)};
  }

 private:
  /// Whether every gap is within rounding of 0, or above it where the force is 0: where only a
  /// regularised problem had a solution, that of the given one may be far away.
  bool is_in_set(const VectorXd& q, const Eigen::Ref<const VectorXd>& lambda,
                 const Eigen::Ref<const VectorXd>& v) const noexcept {
    if (sizes_.n_lambda == 0) return true;
    const double largest = lambda.maxCoeff();
    for (int i = 0; i < sizes_.n_lambda; ++i) {
      double y = q[i], terms = std::abs(lcs_->c[i]), possible = 0.0;
      for (int j = 0; j < sizes_.n_x; ++j) terms += std::abs(lcs_->E(i, j) * v[j]);
      for (int j = 0; j < sizes_.n_u; ++j) terms += std::abs(lcs_->H(i, j) * sizes_.u(v)[j]);
      for (int j = 0; j < sizes_.n_lambda; ++j) {
        y += lcs_->F(i, j) * lambda[j];
        terms += std::abs(lcs_->F(i, j) * lambda[j]);
        possible += std::abs(lcs_->F(i, j)) * largest;
      }
      const bool is_closed = std::abs(y) <= kInSet * terms + kForceRounding * possible;
      if (!(is_closed || (y > 0.0 && lambda[i] == 0.0))) return false;
    }
    return true;
  }

  Sizes sizes_;
  lcs::Lemke lemke_;
  const lcs::Lcs* lcs_ = nullptr;
  Eigen::MatrixXd U_;
  VectorXd difference_, weighted_;
};

}  // namespace

std::unique_ptr<Projection> make_lcp_projection(const Sizes& sizes) {
  return std::make_unique<LcpProjection>(sizes);
}

}  // namespace c3rt::c3
