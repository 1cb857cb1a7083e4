#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "controller/c3/consensus.hpp"
#include "controller/c3/projection.hpp"
#include "controller/qp/requirements.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class PlusProjection final : public Projection {
 public:
  explicit PlusProjection(const Sizes& sizes) : sizes_(sizes) {}

  void set_weights(const Costs& costs) override {
    u_lambda_ = costs.plus.u_lambda;
    u_eta_ = costs.plus.u_eta;
    root_lambda_ = u_lambda_.cwiseSqrt();
    root_eta_ = u_eta_.cwiseSqrt();
  }

  void start(const lcs::Lcs&) noexcept override {}

  ProjectionReport project(const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> delta,
                           const Deadline&) noexcept override {
    delta = v;
    if (!v.allFinite()) return {ProjectionStatus::kNotFinite, 0, 0.0};
    auto lambda = sizes_.lambda(delta);
    auto eta = sizes_.eta(delta);
    double objective = 0.0;
    for (int i = 0; i < sizes_.n_lambda; ++i) {
      // keep the half-axis that is farther away in the weighted norm, drop the other
      const double a = lambda[i], b = eta[i];
      const bool keep_force = root_lambda_[i] * a >= root_eta_[i] * b;
      lambda[i] = keep_force ? std::max(a, 0.0) : 0.0;
      eta[i] = keep_force ? 0.0 : std::max(b, 0.0);
      objective += u_lambda_[i] * (lambda[i] - a) * (lambda[i] - a) +
                   u_eta_[i] * (eta[i] - b) * (eta[i] - b);
    }
    return {ProjectionStatus::kSolved, 0, objective};
  }

 private:
  Sizes sizes_;
  VectorXd u_lambda_, u_eta_, root_lambda_, root_eta_;
};

}  // namespace

std::unique_ptr<Projection> make_plus_projection(const Sizes& sizes) {
  return std::make_unique<PlusProjection>(sizes);
}

namespace {

/// The copy is [z; η] with the gaps η = J z + c, J = [E F H]; W = G_λ + Jᵀ G_η J.
class GapConsensus final : public Consensus {
 public:
  explicit GapConsensus(const Sizes& sizes)
      : sizes_(sizes),
        J_(sizes.N, MatrixXd::Zero(sizes.n_lambda, sizes.n_z())),
        W_(sizes.N, MatrixXd::Zero(sizes.n_z(), sizes.n_z())),
        g_lambda_(MatrixXd::Zero(sizes.n_lambda, sizes.N)),
        g_eta_(MatrixXd::Zero(sizes.n_lambda, sizes.N)),
        y_(VectorXd::Zero(sizes.n_lambda)) {}

  int n_copy() const noexcept override { return sizes_.n_z() + sizes_.n_lambda; }
  void set_weights(const Costs& costs) override { weights_ = costs.plus; }
  /// W fills a whole block; a G that is there all the same says nothing of it.
  PerStage<MatrixXd> pattern(const Costs&) const override { return {}; }

  StageMatrices start(Horizon lcs) noexcept override {
    lcs_ = lcs;
    g_lambda_.colwise() = weights_.g_lambda;
    g_eta_.colwise() = weights_.g_eta;
    const int systems = lcs.stride == 0 ? 1 : sizes_.N;
    for (int k = 0; k < systems; ++k) {
      MatrixXd& J = J_[k];
      J.leftCols(sizes_.n_x) = lcs[k].E;
      J.middleCols(sizes_.n_x, sizes_.n_lambda) = lcs[k].F;
      J.rightCols(sizes_.n_u) = lcs[k].H;
      weigh(k);
    }
    return {W_.data(), lcs.stride == 0 ? 0 : 1};
  }

  /// The side that δ has as zero is drawn there by its multiplied weight.
  StageMatrices finish(const MatrixXd& delta) noexcept override {
    if (weights_.final_scale.size() == 0) return {nullptr, 0};
    for (int k = 0; k < sizes_.N; ++k) {
      const auto lambda = sizes_.lambda(delta.col(k));
      for (int i = 0; i < sizes_.n_lambda; ++i)
        (lambda[i] == 0.0 ? g_lambda_ : g_eta_)(i, k) *= weights_.final_scale[i];
      weigh(k);
    }
    return {W_.data(), 1};
  }

  void set_linear_term(const MatrixXd& deltas, const MatrixXd& ws, MatrixXd& g) noexcept override {
    g.setZero();
    for (int k = 0; k < sizes_.N; ++k) {
      const auto delta = deltas.col(k), w = ws.col(k);
      sizes_.lambda(g.col(k)) =
          g_lambda_.col(k).cwiseProduct(sizes_.lambda(delta) - sizes_.lambda(w));
      y_ = g_eta_.col(k).cwiseProduct(sizes_.eta(delta) - sizes_.eta(w) - lcs_[k].c);
      g.col(k).noalias() += J_[k * lcs_.stride].transpose() * y_;
    }
  }

  void append(MatrixXd& copy) noexcept override {
    for (int k = 0; k < sizes_.N; ++k) {
      y_ = lcs_[k].c;
      y_.noalias() += J_[k * lcs_.stride] * copy.col(k).head(sizes_.n_z());
      sizes_.eta(copy.col(k)) = y_;
    }
  }

 private:
  void weigh(int k) noexcept {
    const MatrixXd& J = J_[k * lcs_.stride];
    MatrixXd& W = W_[k];
    W.setZero();
    W.diagonal().segment(sizes_.n_x, sizes_.n_lambda) = g_lambda_.col(k);
    // row by row: contact rows are mostly zeros
    for (int row = 0; row < sizes_.n_lambda; ++row) {
      for (int col = 0; col < sizes_.n_z(); ++col) {
        const double weighted = g_eta_(row, k) * J(row, col);
        if (weighted == 0.0) continue;
        for (int other = 0; other < sizes_.n_z(); ++other)
          W(other, col) += weighted * J(row, other);
      }
    }
  }

  Sizes sizes_;
  PlusWeights weights_;
  Horizon lcs_{nullptr, 0};
  std::vector<MatrixXd> J_;    // (n_lambda × n_z), N of them
  std::vector<MatrixXd> W_;    // (n_z × n_z), N of them
  MatrixXd g_lambda_, g_eta_;  // (n_lambda × N)
  VectorXd y_;
};

std::unique_ptr<Consensus> make_gap_consensus(const Sizes& sizes) {
  return std::make_unique<GapConsensus>(sizes);
}

void check_plus(const Costs& costs, const Sizes& sizes) {
  qp::require_vector("Costs.plus.g_lambda", costs.plus.g_lambda, sizes.n_lambda, true);
  qp::require_vector("Costs.plus.g_eta", costs.plus.g_eta, sizes.n_lambda, true);
  qp::require_vector("Costs.plus.u_lambda", costs.plus.u_lambda, sizes.n_lambda, false);
  qp::require_vector("Costs.plus.u_eta", costs.plus.u_eta, sizes.n_lambda, false);
  const VectorXd& scale = costs.plus.final_scale;
  if (scale.size() == 0) return;
  qp::require_vector("Costs.plus.final_scale", scale, sizes.n_lambda, true);
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    if (!(scale[i] >= 1.0))
      throw std::invalid_argument("Costs.plus.final_scale[" + std::to_string(i) +
                                  "]: expected a number of 1 or more, got " +
                                  std::to_string(scale[i]));
  }
}

std::vector<ProjectionWeight> plus_weights() {
  using Shape = ProjectionWeight::Shape;
  ProjectionWeight g_lambda{"g_lambda", "g_lambda", Shape::kOfForces};
  ProjectionWeight g_eta{"g_eta", "g_eta", Shape::kOfGaps};
  ProjectionWeight u_lambda{"u_lambda", "u_lambda", Shape::kOfForces};
  ProjectionWeight u_eta{"u_eta", "u_eta", Shape::kOfGaps};
  g_lambda.vector = [](Costs& costs) -> VectorXd& { return costs.plus.g_lambda; };
  g_eta.vector = [](Costs& costs) -> VectorXd& { return costs.plus.g_eta; };
  u_lambda.vector = [](Costs& costs) -> VectorXd& { return costs.plus.u_lambda; };
  u_eta.vector = [](Costs& costs) -> VectorXd& { return costs.plus.u_eta; };
  for (ProjectionWeight* weight : {&g_lambda, &g_eta, &u_lambda, &u_eta}) weight->minimum = 1e-12;
  g_lambda.of_consensus = g_eta.of_consensus = true;
  ProjectionWeight final_scale{"final_scale", "final_scale", Shape::kOfContacts};
  final_scale.vector = [](Costs& costs) -> VectorXd& { return costs.plus.final_scale; };
  final_scale.minimum = 1.0;
  final_scale.has_default = true;
  return {g_lambda, g_eta, u_lambda, u_eta, final_scale};
}

}  // namespace

const ProjectionType& plus_projection() {
  static const ProjectionType type{
      ProjectionKind::kPlus,
      "plus",
      "C3+",
      false,
      false,
      [](const Sizes& sizes, const Settings&) { return make_plus_projection(sizes); },
      make_gap_consensus,
      check_plus,
      nullptr,
      plus_weights()};
  return type;
}

}  // namespace c3rt::c3
