#pragma once
// The whole loop in one process, without DDS: plant, emulated sensing, planner and impedance law,
// in the order and with the delays of a lockstep run. For tests of behaviour and for tuning.
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
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
  /// Whether vision sees the balls.
  void set_in_view(bool in_view) { in_view_ = in_view; }
  /// Which processes run; the last words of the others stay as they were.
  struct Running {
    bool plant = true, vision = true, planner = true, impedance = true;
  };
  Running running;
  void set_planner_runs(bool runs) { running.planner = runs; }
  void set_vision_runs(bool runs) { running.vision = runs; }
  void restart_impedance();
  void restart_planner();
  void restart_vision();
  /// What `c3rt stop` and `c3rt recover` ask of all.
  void stop();
  void recover();
  /// Changes every plan before it is sent, as another planner would.
  std::function<void(impedance::Plan&)> spoil_plan;
  /// The robot's states are not finite while this is set.
  bool nan_state = false;
  /// They do not arrive while this is set; the robot goes on.
  bool lost_state = false;

  double time() const { return 1e-9 * static_cast<double>(now_ns_); }
  plant::Plant& plant() { return plant_; }
  const planner::Planner& planner() const { return *planner_; }
  const planner::Plan& plan() const { return plan_; }          // the newest computed
  const impedance::Output& output() const { return output_; }  // of the last cycle
  double fastest_joint() const { return fastest_joint_; }      // so far, 1: at its limit
  const vision::Estimate& estimate(int ball = 0) const {
    return estimators_[static_cast<std::size_t>(ball)].estimate();
  }

 private:
  void plan_now();
  void control();
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
  std::optional<planner::Planner> planner_;
  std::optional<impedance::Controller> impedance_;
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
  bool in_view_ = true;
  bool stopped_ = false;                 // the planner was told so
  bool stop_ = false, recover_ = false;  // requests to the impedance process
  double fastest_joint_ = 0.0;
  plant::State heard_;                      // the newest robot state that arrived
  std::int64_t now_ns_ = 0, state_ns_ = 0;  // state_ns_: of the newest robot state
  std::uint64_t cycle_ = 0, exposures_ = 0, plans_made_ = 0;
};

}  // namespace c3rt::test
