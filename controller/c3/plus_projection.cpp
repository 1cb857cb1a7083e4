#include <algorithm>
#include <cmath>

#include "controller/c3/projection.hpp"

namespace c3rt::c3 {
namespace {

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

}  // namespace c3rt::c3
