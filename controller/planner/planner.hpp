#pragma once
// The planner as one function of its inputs: what of them can be used → the scene → the strategy →
// Algorithm 3 → (x_d, λ_d).
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "controller/planner/availability.hpp"
#include "controller/planner/c3_controller.hpp"
#include "controller/planner/input.hpp"
#include "controller/planner/parameters.hpp"
#include "controller/planner/plan.hpp"
#include "controller/planner/strategy/strategy.hpp"

namespace c3rt::planner {

class Planner {
 public:
  /// @throws std::invalid_argument if the strategy, weights or sizes cannot be used (named)
  /// @param parallel threads for a strategy that plans for several places at once
  explicit Planner(const Parameters& parameters, const c3::Parallel& parallel = {});
  /// The same with a strategy that the registry does not know.
  using MakeStrategy = std::unique_ptr<Strategy> (*)(const Parameters&, C3Controller&);
  Planner(const Parameters& parameters, MakeStrategy make, const c3::Parallel& parallel = {});

  /// One control period. Never throws: a solve that fails, or a failure of any kind within, gives a
  /// fallback plan that holds the end effector where it is.
  /// @param deadline asked between steps of the solve; lockstep passes none
  const Plan& step(const Input& input, c3::Deadline deadline = {}) noexcept;

  /// From the next period on Algorithm 1 weighs as these parameters do, which are else those that
  /// the planner was made from. The strategy goes on where it is.
  /// @throws std::invalid_argument if they cannot be used (named)
  void set_weights(const Parameters& parameters) { strategy_->set_weights(parameters, c3_); }

  struct Counters {
    std::uint64_t fallbacks = 0, truncated = 0, lcp_failures = 0, speed_clamped = 0, body_lost = 0;
    std::uint64_t branch_nodes = 0;
    std::uint64_t failures = 0;  // of the planner's own: something threw
  };
  const Counters& counters() const noexcept { return counters_; }
  /// What was thrown last, cut off where it is too long; empty where nothing was.
  const char* failure() const noexcept { return failure_.data(); }

  /// What it is doing and why.
  const Activity& activity() const noexcept { return activity_; }

 private:
  void compose(const Input& input, const c3::Deadline& deadline);
  /// The bodies at the time of the arm's state.
  scene::Scene estimate(const Input& input) const;
  double measured_period(const Input& input, bool& interrupted);
  double delta_t_c(const Input& input) const;
  void plan_with_c3(const Input& input, const Decision& decision, const c3::Deadline& deadline);
  void hold(const Eigen::Vector3d& p_WE);
  /// Keeps activity() true.
  void tell(const Situation& situation, const Decision& decision);

  Parameters parameters_;
  const c3::Parallel parallel_;
  C3Controller c3_;
  std::unique_ptr<Strategy> strategy_;
  double previous_now_ = -1.0;
  double followed_ = -1.0;  // the robot last followed; negative: not yet [s]
  static constexpr int kPeriodsAveraged = 10;
  std::array<double, kPeriodsAveraged> periods_{};  // the newest at period_count_ - 1
  int period_count_ = 0;
  Activity activity_;
  Plan plan_;
  Counters counters_;
  std::array<char, 256> failure_{};
};

}  // namespace c3rt::planner
