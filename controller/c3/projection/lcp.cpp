#include "controller/c3/consensus.hpp"
#include "controller/c3/projection.hpp"
#include "controller/lcs/step.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::VectorXd;

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
    const lcs::LcpReport lcp =
        lcs::solve_lcp(*lcs_, sizes_.x(v), sizes_.u(v), lemke_, sizes_.lambda(delta));
    if (lcp.status != lcs::LcpStatus::kSolved) {
      delta = v;
      return {lcp.status == lcs::LcpStatus::kInaccurate ? ProjectionStatus::kInaccurate
                                                        : ProjectionStatus::kNotFound,
              lcp.pivots, 0.0};
    }
    difference_ = delta - v;
    if (U_.size() == 0) return {ProjectionStatus::kSolved, lcp.pivots, difference_.squaredNorm()};
    weighted_.noalias() = U_ * difference_;
    return {ProjectionStatus::kSolved, lcp.pivots, difference_.dot(weighted_)};
  }

 private:
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

namespace {

std::string why_no_point_of_lcp(const ProjectionReport& report, const Settings&, const Costs&,
                                const lcs::Lcs&) {
  return report.status == ProjectionStatus::kNotFound
             ? "Lemke's method finds no solution of the LCP"
             : "";
}

}  // namespace

const ProjectionType& lcp_projection() {
  static const ProjectionType type{
      ProjectionKind::kLcp,
      "lcp",
      "LCP",
      true,
      false,
      [](const Sizes& sizes, const Settings&) { return make_lcp_projection(sizes); },
      make_consensus,
      nullptr,
      nullptr,
      {},
      why_no_point_of_lcp};
  return type;
}

}  // namespace c3rt::c3
