#pragma once
// The exact search in the place of C3.
#include <optional>
#include <vector>

#include "cli/progress.hpp"
#include "controller/example/controller.hpp"
#include "controller/horizon/modes.hpp"

namespace c3rt::cli {

/// What a search came to.
struct ExactDecision {
  double gap;   // between the plan and what is proven, in relation to it; kNone without a plan
  bool proven;  // to 1e-4
};

/// The monolithic problem [C3, eq. (15)] in the place of C3: the exact search over the whole
/// horizon, each with a time limit. It starts from the best of a few plans, each the best with its
/// modes: those of C3's plan and those of the last plan one stage on. Without a plan to start from,
/// it finds none worth applying in seconds once N is 20.
class ExactController final : public example::Controller {
 public:
  /// @param experiment with the settings of C3, which finds the plan to start from
  /// @param limit of one decision [s]
  /// @param stop  ends a decision early
  ExactController(const example::Experiment& experiment, double limit, Stop stop);

  void reset() override;
  const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x, double t) override;

  /// Every decision so far.
  const std::vector<ExactDecision>& decisions() const { return decisions_; }

 private:
  static bool is_late(void* self) noexcept;
  std::optional<horizon::Plan> first_plan(const horizon::Problem& problem, const lcs::Lcs& lcs,
                                          double t);
  const example::Experiment& experiment_;
  example::C3Controller c3_;
  std::vector<horizon::Side> last_;  // modes of the last plan
  c3::Sizes sizes_;
  double limit_, end_ = 0.0;  // [s]
  Stop stop_;
  Eigen::MatrixXd u_;
  std::vector<ExactDecision> decisions_;
};

}  // namespace c3rt::cli
