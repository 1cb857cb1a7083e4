#pragma once
// The whole loop in one process, without DDS: plant, emulated sensing, planner and impedance law,
// in the order and with the delays of a lockstep run. For tests of behaviour and for tuning.
#include <cstdint>
#include <deque>
#include <vector>

#include "config/scenario.hpp"
#include "controller/impedance/controller.hpp"
#include "controller/planner/planner.hpp"
#include "plant_emulator/plant.hpp"
#include "vision/emulated.hpp"
#include "vision/track/estimator.hpp"

namespace c3rt::test {

class ClosedLoop {
 public:
  ClosedLoop(const config::Scenario& scenario, std::uint64_t seed);
  void step_1ms();

  /// What a client wants of the planner.
  void set_target(const planner::Target& target) { target_ = target; }
  /// Whether vision sees the balls, and whether the planner and vision run at all.
  void set_in_view(bool in_view) { in_view_ = in_view; }
  void set_planner_runs(bool runs) { planner_runs_ = runs; }
  void set_vision_runs(bool runs) { vision_runs_ = runs; }

  double time() const { return 1e-9 * static_cast<double>(now_ns_); }
  plant::Plant& plant() { return plant_; }
  const planner::Planner& planner() const { return planner_; }
  const planner::Plan& plan() const { return plan_; }          // the newest computed
  const impedance::Output& output() const { return output_; }  // of the last cycle
  const vision::Estimate& estimate(int ball = 0) const {
    return estimators_[static_cast<std::size_t>(ball)].estimate();
  }

 private:
  void plan_now();
  template <typename T>
  struct Stamped {
    std::int64_t time_ns;  // takes effect
    T value;
  };

  config::Scenario scenario_;
  plant::Plant plant_;
  vision::EmulatedSensor sensor_;
  std::vector<vision::Estimator> estimators_;
  std::vector<plant::Push> pushes_;
  std::size_t pushed_ = 0;
  planner::Planner planner_;
  impedance::Controller impedance_;
  model::Arm arm_;
  model::ArmState arm_state_;
  using Estimates = std::vector<vision::Estimate>;  // one per ball
  std::deque<Stamped<Estimates>> estimates_;
  std::deque<Stamped<impedance::Plan>> plans_;
  Estimates newest_estimates_;  // empty before the first
  impedance::Plan newest_plan_;
  bool has_plan_ = false;
  planner::Plan plan_;
  impedance::Output output_{};
  planner::Target target_ = planner::ScenarioTarget{};
  bool in_view_ = true, planner_runs_ = true, vision_runs_ = true;
  std::int64_t now_ns_ = 0;
  std::uint64_t cycle_ = 0, exposures_ = 0, plans_made_ = 0;
};

}  // namespace c3rt::test
