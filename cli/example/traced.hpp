#pragma once
// C3 with its iterates kept, and what one projection of them takes.
#include <memory>
#include <vector>

#include "controller/c3/projection.hpp"
#include "controller/c3/solver.hpp"
#include "controller/example/controller.hpp"

namespace c3rt::cli {

/// Of the projections of one decision.
struct ProjectionTimes {
  double mean;     // of one [s]; kNone where there was none
  int not_solved;  // how many
};

/// The experiment with the solver's trace kept, which a TracedController needs.
example::Experiment traced(example::Experiment experiment);

/// Lets C3 decide, then projects once more what each of its projections was given, with a
/// stopwatch: inside the solver there is no clock.
class TracedController final : public example::Controller {
 public:
  /// @param experiment as traced() gives it; these outlive the controller
  /// @param c3 of that experiment
  /// @param decider decides by c3
  TracedController(const example::Experiment& experiment, const example::C3Controller& c3,
                   example::Controller& decider);

  void reset() override { decider_.reset(); }
  const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x, double t) override;

  /// Of every decision so far.
  const std::vector<ProjectionTimes>& projections() const { return projections_; }
  /// Of the first decision: its iterates, and the planning system that they are of.
  const std::vector<c3::Iterate>& first_iterates() const { return first_iterates_; }
  const lcs::Lcs& first_system() const { return first_system_; }

 private:
  ProjectionTimes rehearse(const lcs::Lcs& lcs);
  const example::C3Controller& c3_;
  example::Controller& decider_;
  std::unique_ptr<c3::Projection> projection_;
  double rho_scale_;
  Eigen::MatrixXd delta_;
  std::vector<ProjectionTimes> projections_;
  std::vector<c3::Iterate> first_iterates_;
  lcs::Lcs first_system_;
};

}  // namespace c3rt::cli
