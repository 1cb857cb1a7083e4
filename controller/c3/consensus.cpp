#include "controller/c3/consensus.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;

class ConsensusOfZ final : public Consensus {
 public:
  explicit ConsensusOfZ(const Sizes& sizes)
      : sizes_(sizes), target_(MatrixXd::Zero(sizes.n_z(), sizes.N)) {}

  int n_copy() const noexcept override { return sizes_.n_z(); }
  void set_weights(const Costs& costs) override { G_ = costs.G; }
  PerStage<MatrixXd> pattern(const Costs& costs) const override { return costs.G; }

  StageMatrices start(Horizon) noexcept override { return {G_.data(), G_.count() == 1 ? 0 : 1}; }

  void set_linear_term(const MatrixXd& delta, const MatrixXd& w, MatrixXd& g) noexcept override {
    target_ = delta - w;
    for (int k = 0; k < sizes_.N; ++k) g.col(k).noalias() = G_[k] * target_.col(k);
  }

  void append(MatrixXd&) noexcept override {}

 private:
  Sizes sizes_;
  PerStage<MatrixXd> G_;
  MatrixXd target_;  // (n_z × N)
};

}  // namespace

std::unique_ptr<Consensus> make_consensus(const Sizes& sizes) {
  return std::make_unique<ConsensusOfZ>(sizes);
}

}  // namespace c3rt::c3
