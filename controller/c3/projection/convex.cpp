#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "controller/c3/consensus.hpp"
#include "controller/c3/projection.hpp"
#include "controller/c3/projection/pair_rows.hpp"
#include "controller/qp/bound.hpp"
#include "controller/qp/node_qp.hpp"
#include "controller/qp/requirements.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using qp::kInfinity;
using qp::NodeQp;

constexpr double kSingularPivot = 1e-13;  // of the diagonal's entry: a pivot that counts as none
constexpr double kAddedToPivot = 1e-8;    // of the diagonal's entry, for F without full rank

/// With S = sym F + ε I the cost in λ is ½ ‖λ − α v_λ‖²_S and a constant, so that all of it is the
/// distance from [v_x; α v_λ; v_u] in the norm of W = blkdiag(Q_x, S, Q_u) = L Lᵀ. With
/// δ = [v_x; α v_λ; v_u] + L⁻ᵀ f it is a NodeQp on the columns of L⁻¹ Jᵀ with nothing pinned.
class ConvexProjection final : public Projection {
 public:
  explicit ConvexProjection(const Sizes& sizes)
      : sizes_(sizes),
        n_(sizes.n_lambda),
        S_(n_, n_),
        cholesky_(n_),
        rows_(sizes),
        qp_(sizes.n_z(), 2 * n_),
        difference_(sizes.n_z()),
        weighted_(sizes.n_z()) {}

  void set_weights(const Costs& costs) override {
    U_ = costs.U;
    alpha_ = costs.convex.alpha;
    epsilon_ = costs.convex.epsilon;
    L_x_ = costs.convex.Q_x.llt().matrixL();
    L_u_ = costs.convex.Q_u.llt().matrixL();
  }

  void start(const lcs::Lcs& lcs) noexcept override {
    is_convex_ = n_ == 0 || factorise(lcs.F);
    if (!is_convex_ || n_ == 0) return;
    const int n_x = sizes_.n_x, n_u = sizes_.n_u;
    rows_.assign(lcs);
    auto C_x = rows_.C.block(0, n_, n_x, n_);
    auto C_lambda = rows_.C.middleRows(n_x, n_);
    auto C_u = rows_.C.block(n_x + n_, n_, n_u, n_);
    C_x = lcs.E.transpose();
    C_lambda.leftCols(n_).setIdentity();
    C_lambda.rightCols(n_) = lcs.F.transpose();
    C_u = lcs.H.transpose();
    L_x_.triangularView<Eigen::Lower>().solveInPlace(C_x);
    cholesky_.matrixL().solveInPlace(C_lambda);
    L_u_.triangularView<Eigen::Lower>().solveInPlace(C_u);
    rows_.normalise();
  }

  ProjectionReport project(const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> delta,
                           const Deadline&) noexcept override {
    delta = v;
    if (!v.allFinite()) return {ProjectionStatus::kNotFinite, 0, 0.0};
    if (!is_convex_) return {ProjectionStatus::kNotConvex, 0, 0.0};
    if (n_ == 0) return {ProjectionStatus::kSolved, 1, 0.0};  // nothing is excluded
    sizes_.lambda(delta) *= alpha_;
    rows_.evaluate(delta);
    const double tolerance = kFeasible * rows_.largest;
    qp_.start(rows_.t);
    const NodeQp::Status status = qp_.solve(rows_.C, rows_.t, tolerance, kInfinity);
    if (status != NodeQp::Status::kSolved) {
      delta = v;
      return {status == NodeQp::Status::kInfeasible ? ProjectionStatus::kEmpty
                                                    : ProjectionStatus::kNotFound,
              1, 0.0};
    }
    qp_.refine(rows_.C, rows_.t);
    const int n_x = sizes_.n_x;
    difference_ = qp_.f();
    L_x_.transpose().triangularView<Eigen::Upper>().solveInPlace(difference_.head(n_x));
    auto difference_lambda = difference_.segment(n_x, n_);
    cholesky_.matrixU().solveInPlace(difference_lambda);
    auto difference_u = difference_.tail(sizes_.n_u);
    L_u_.transpose().triangularView<Eigen::Upper>().solveInPlace(difference_u);
    delta += difference_;
    for (int i = 0; i < n_; ++i) {  // an active side is zero, without the rounding
      double& force = delta[n_x + i];
      force = qp_.s()[i] == 0.0 ? 0.0 : std::max(force, 0.0);
    }
    if (!delta.allFinite()) {
      delta = v;
      return {ProjectionStatus::kInaccurate, 1, 0.0};
    }
    difference_ = delta - v;
    if (U_.size() == 0) return {ProjectionStatus::kSolved, 1, difference_.squaredNorm()};
    weighted_.noalias() = U_ * difference_;
    return {ProjectionStatus::kSolved, 1, difference_.dot(weighted_)};
  }

 private:
  /// Cholesky of S, each entry of the diagonal judged beside itself, so that the units of the
  /// single forces do not count. Where S has not full rank, 1e-8 of the diagonal is added to it.
  bool factorise(const MatrixXd& F) noexcept {
    S_ = 0.5 * F;
    S_ += 0.5 * F.transpose();
    S_.diagonal().array() += epsilon_;
    if (S_.diagonal().minCoeff() < 0.0) return false;
    cholesky_.compute(S_);
    if (is_definite()) return true;
    const double largest = S_.diagonal().maxCoeff();
    for (int i = 0; i < n_; ++i) {
      S_(i, i) += kAddedToPivot * (S_(i, i) > 0.0 ? S_(i, i) : largest > 0.0 ? largest : 1.0);
    }
    cholesky_.compute(S_);
    return is_definite();
  }

  bool is_definite() const noexcept {
    if (cholesky_.info() != Eigen::Success) return false;
    for (int i = 0; i < n_; ++i) {
      const double pivot = cholesky_.matrixLLT()(i, i);
      if (!(pivot * pivot > kSingularPivot * S_(i, i))) return false;
    }
    return true;
  }

  Sizes sizes_;
  int n_;  // pairs
  double alpha_ = 0.0, epsilon_ = 0.0;
  MatrixXd U_, L_x_, L_u_;
  MatrixXd S_;
  Eigen::LLT<MatrixXd> cholesky_;  // of S
  bool is_convex_ = false;
  PairRows rows_;  // with T = L⁻ᵀ
  NodeQp qp_;
  VectorXd difference_, weighted_;
};

}  // namespace

std::unique_ptr<Projection> make_convex_projection(const Sizes& sizes) {
  return std::make_unique<ConvexProjection>(sizes);
}

namespace {

void check_convex(const Costs& costs, const Sizes& sizes) {
  qp::require_definite("Costs.convex.Q_x", costs.convex.Q_x, sizes.n_x);
  qp::require_definite("Costs.convex.Q_u", costs.convex.Q_u, sizes.n_u);
  if (!(costs.convex.alpha >= 0.0 && costs.convex.alpha <= 1.0)) {
    qp::refuse("Costs.convex.alpha", "a number from 0 to 1", qp::text(costs.convex.alpha));
  }
  if (!(costs.convex.epsilon >= 0.0 && std::isfinite(costs.convex.epsilon))) {
    qp::refuse("Costs.convex.epsilon", "a number of 0 or more", qp::text(costs.convex.epsilon));
  }
}

std::string why_not_convex(const ProjectionReport& report, const Settings&, const Costs& costs,
                           const lcs::Lcs& lcs) {
  if (report.status != ProjectionStatus::kNotConvex) return "";
  const MatrixXd twice = lcs.F + lcs.F.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(twice, Eigen::EigenvaluesOnly);
  std::ostringstream text;
  text << "the convex projection needs F + eps I positive semidefinite, its smallest eigenvalue is "
       << 0.5 * eigen.eigenvalues()[0] + costs.convex.epsilon;
  return text.str();
}

std::vector<ProjectionWeight> convex_weights() {
  using Shape = ProjectionWeight::Shape;
  ProjectionWeight Q_x{"Q_x", "Qx", Shape::kOfStates}, Q_u{"Q_u", "Qu", Shape::kOfInputs};
  ProjectionWeight alpha{"alpha", "alpha", Shape::kNumber};
  ProjectionWeight epsilon{"epsilon", "eps", Shape::kNumber};
  Q_x.matrix = [](Costs& costs) -> MatrixXd& { return costs.convex.Q_x; };
  Q_u.matrix = [](Costs& costs) -> MatrixXd& { return costs.convex.Q_u; };
  Q_x.minimum = Q_u.minimum = 1e-12;
  alpha.number = [](Costs& costs) -> double& { return costs.convex.alpha; };
  alpha.maximum = 1.0;
  epsilon.number = [](Costs& costs) -> double& { return costs.convex.epsilon; };
  epsilon.has_default = true;
  return {Q_x, Q_u, alpha, epsilon};
}

}  // namespace

const ProjectionType& convex_projection() {
  static const ProjectionType type{
      ProjectionKind::kConvex,
      "convex",
      "CONVEX",
      true,
      false,
      [](const Sizes& sizes, const Settings&) { return make_convex_projection(sizes); },
      make_consensus,
      check_convex,
      nullptr,
      convex_weights(),
      why_not_convex};
  return type;
}

}  // namespace c3rt::c3
