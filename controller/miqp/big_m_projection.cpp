#include "controller/miqp/big_m_projection.hpp"

#include <limits>

namespace c3rt::miqp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// In the variables [δ; b]: y = E δ_x + F δ_λ + H δ_u + c ≤ M (1 − b), δ_λ ≤ M b.
class BigMProjection final : public c3::Projection {
 public:
  BigMProjection(const c3::Sizes& sizes, double big_m, const Settings& settings)
      : sizes_(sizes), big_m_(big_m), settings_(settings) {}

  void set_weights(const c3::Costs& costs) override { U_ = costs.U; }

  void start(const lcs::Lcs& lcs) noexcept override { lcs_ = &lcs; }

  c3::ProjectionReport project(const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> delta,
                               const c3::Deadline&) noexcept override {
    delta = v;
    if (!v.allFinite()) return {c3::ProjectionStatus::kNotFinite, 0, 0.0};
    const Result result = solve(problem(v), settings_);
    if (result.x.size() == 0) {
      return {result.status == Status::kInfeasible ? c3::ProjectionStatus::kEmpty
                                                   : c3::ProjectionStatus::kNotFound,
              result.nodes, 0.0};
    }
    delta = result.x.head(v.size());
    const auto status = result.status == Status::kOptimal ? c3::ProjectionStatus::kSolved
                                                          : c3::ProjectionStatus::kNodeLimit;
    return {status, result.nodes, result.objective};
  }

 private:
  Problem problem(const VectorXd& v) const {
    const int n_z = sizes_.n_z(), n = sizes_.n_lambda;
    const VectorXd none = VectorXd::Constant(n, std::numeric_limits<double>::infinity());
    MatrixXd P = MatrixXd::Zero(n_z + n, n_z + n);
    P.topLeftCorner(n_z, n_z) = U_;
    MatrixXd A = MatrixXd::Zero(3 * n, n_z + n);
    A.block(0, 0, n, sizes_.n_x) = lcs_->E;
    A.block(0, sizes_.n_x, n, n) = lcs_->F;
    A.block(0, sizes_.n_x + n, n, sizes_.n_u) = lcs_->H;
    A.middleRows(n, n) = A.topRows(n);
    A.block(n, n_z, n, n).diagonal().setConstant(big_m_);
    A.block(2 * n, sizes_.n_x, n, n).setIdentity();
    A.block(2 * n, n_z, n, n).diagonal().setConstant(-big_m_);

    Problem result;
    result.P = P.sparseView();
    result.q = VectorXd::Zero(n_z + n);
    result.q.head(n_z).noalias() = -U_ * v;
    result.constant = -v.dot(result.q.head(n_z));
    result.A = A.sparseView();
    result.l.resize(3 * n);
    result.l << -lcs_->c, -none, -none;
    result.u.resize(3 * n);
    result.u << none, VectorXd::Constant(n, big_m_) - lcs_->c, VectorXd::Zero(n);
    result.x_min = VectorXd::Constant(n_z + n, -std::numeric_limits<double>::infinity());
    result.x_max = -result.x_min;
    result.x_min.segment(sizes_.n_x, n).setZero();
    result.x_min.tail(n).setZero();
    result.x_max.tail(n).setOnes();
    for (int i = 0; i < n; ++i) result.binaries.push_back(n_z + i);
    return result;
  }

  c3::Sizes sizes_;
  double big_m_;
  Settings settings_;
  MatrixXd U_;
  const lcs::Lcs* lcs_ = nullptr;
};

}  // namespace

std::unique_ptr<c3::Projection> make_big_m_projection(const c3::Sizes& sizes, double big_m,
                                                      const Settings& settings) {
  return std::make_unique<BigMProjection>(sizes, big_m, settings);
}

}  // namespace c3rt::miqp
