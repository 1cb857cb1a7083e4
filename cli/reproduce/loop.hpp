#pragma once
// One closed loop of an example, timed.
#include <memory>
#include <optional>

#include "cli/reproduce/context.hpp"
#include "controller/example/closed_loop.hpp"
#include "controller/horizon/modes.hpp"
#include "controller/horizon/search.hpp"

namespace c3rt::cli::reproduce {

/// The monolithic MIQP [C3, eq. (15)] in the place of C3: the exact search over the whole horizon,
/// each with a time limit. It starts from the better of two plans, each the best with its modes:
/// those of C3's plan and those of the last plan one stage on. Without a plan to start from, it
/// finds none worth applying in seconds once N is 20.
class MonolithicController final : public example::Controller {
 public:
  /// @param starter  how C3 finds the plan to start from
  /// @param limit of one decision [s]
  /// @param stop  ends a decision early
  MonolithicController(const example::Experiment& experiment, const example::Experiment& starter,
                       double limit, Stop stop);

  void reset() override;
  const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x, double t) override;

  /// Of every decision so far, as horizon::SearchResult says.
  int decisions() const { return static_cast<int>(gaps_.size()); }
  int proven() const { return proven_; }
  const std::vector<double>& gaps() const { return gaps_; }

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
  std::vector<double> gaps_;
  int proven_ = 0;
};

/// Runs trial 0 with seed 1.
/// @throws Interrupted
example::Trajectory run_loop(const Context& context, const std::string& title,
                             const ExampleScenario& scenario, example::Controller& controller,
                             int trial = 0);

/// {accumulated_cost, mean_cost_to_go, succeeded, controller_failures, plant_failed, overshoot,
/// calls, solve_time_s{…}}; overshoot: how far the simulated states went beyond the bounds of C.
ordered_json loop_figures(const example::Experiment& experiment,
                          const example::Trajectory& trajectory,
                          const std::vector<double>& solve_times);

/// The closed loop with C3, as figures.
ordered_json measure_c3(const Context& context, const std::string& title,
                        const ExampleScenario& scenario);

/// The closed loop with the monolithic MIQP, which starts from C3 with the settings of `starter`;
/// also {proven, gap_mean, gap_max}.
ordered_json measure_monolithic(const Context& context, const std::string& title,
                                const ExampleScenario& scenario, const ExampleScenario& starter);

}  // namespace c3rt::cli::reproduce
