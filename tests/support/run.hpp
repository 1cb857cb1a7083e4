#pragma once
// A run in one process for tests of behaviour: the nodes of `c3rt run --in-process`, clients that
// ask them for something, and lines that spoil or lose samples.
#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "cli/in_process.hpp"
#include "idl/convert.hpp"
#include "idl/exchange.hpp"

namespace c3rt::test {

class Run {
 public:
  Run(const config::Scenario& scenario, std::uint64_t seed)
      : dq_max_(scenario.plant.limits.dq_max),
        settings_(settings()),
        nodes_(scenario, seed, settings_),
        bus_(settings_),
        targets_(bus_),
        requests_(bus_),
        faults_(bus_) {
    settings_.exchange->set_filter<wire::RobotState>([this](wire::RobotState& state) {
      if (nan_state) state.q_rad[0] = std::numeric_limits<double>::quiet_NaN();
      return !lost_state;
    });
    settings_.exchange->set_filter<wire::Plan>([this](wire::Plan& plan) {
      if (spoil_plan) spoil_plan(plan);
      return true;
    });
  }

  void step_1ms() {
    nodes_.set_running(c3rt_v2_PROCESS_PLANT, running.plant);
    nodes_.set_running(c3rt_v2_PROCESS_VISION, running.vision);
    nodes_.set_running(c3rt_v2_PROCESS_PLANNER, running.planner);
    nodes_.set_running(c3rt_v2_PROCESS_IMPEDANCE, running.impedance);
    nodes_.advance();
    const double fastest = (plant().state().dq.array().abs() / dq_max_.array()).maxCoeff();
    fastest_joint_ = std::max(fastest_joint_, fastest);
  }
  void until(double time) {
    while (this->time() < time) step_1ms();
  }

  // what clients ask for
  void hold() { ask_for({"hold", {}}); }
  void go_on() { ask_for({"scenario", {}}); }
  void bring_to(const Eigen::Vector2d& point) {
    ask_for({"pose",
             {{"goals_m", {point.x(), point.y()}, ""},
              {"position_tolerance_m", {0.01}, ""},
              {"hold_s", {1.0}, ""}}});
  }
  void ask_for(const task::Request& request) {
    wire::TaskTarget target = wire::task_target(request);
    targets_.write(target, nodes_.now_ns());
  }
  /// What `c3rt stop` and `c3rt recover` ask of all.
  void stop() { request(c3rt_v2_REQUEST_STOP); }
  void recover() { request(c3rt_v2_REQUEST_RECOVER); }
  /// Whether vision sees the objects.
  void set_in_view(bool in_view) {
    wire::FaultInject fault{};
    fault.process = c3rt_v2_PROCESS_VISION;
    fault.kind = in_view ? c3rt_v2_FAULT_NONE : c3rt_v2_FAULT_LOSE_OBJECT;
    fault.duration_s = in_view ? 0.0 : 1000.0;
    faults_.write(fault, nodes_.now_ns());
  }

  /// Which processes run; the last words of the others stay as they were.
  struct Running {
    bool plant = true, vision = true, planner = true, impedance = true;
  };
  Running running;
  void restart(wire::Process process) { nodes_.restart(process); }
  /// Changes every plan on its way, as another planner would.
  std::function<void(wire::Plan&)> spoil_plan;
  bool nan_state = false;   // the robot's states are not finite on their way
  bool lost_state = false;  // they do not arrive; the robot goes on

  double time() const { return 1e-9 * static_cast<double>(nodes_.now_ns()); }  // [s]
  const plant::Plant& plant() const { return nodes_.plant().plant(); }
  const planner::Planner& planner() const { return nodes_.planner().planner(); }
  planner::Mode mode() const { return planner().activity().mode; }
  /// Where the newest plan wants the end effector.
  Eigen::Vector3d p_WE_planned() const {
    return Eigen::Map<const Eigen::Vector3d>(nodes_.planner().output().plan.knots[0].p_WE_m);
  }
  const impedance::Output& control() const { return nodes_.impedance().output().control; }
  double fastest_joint() const { return fastest_joint_; }  // so far, 1: at its limit

 private:
  static wire::BusSettings settings() {
    wire::BusSettings result;
    result.clock = wire::ClockMode::kLockstep;
    result.session_id = 1;
    result.exchange = wire::make_exchange();
    return result;
  }
  void request(c3rt_v2_RequestVerb verb) {
    for (const wire::Process process :
         {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER}) {
      wire::ServiceRequest request{};
      request.process = process;
      request.verb = verb;
      requests_.write(request, nodes_.now_ns());
    }
  }

  const plant::Vector7d dq_max_;  // [rad/s]
  const wire::BusSettings settings_;
  cli::InProcess nodes_;
  wire::Bus bus_;
  wire::Writer<wire::TaskTarget> targets_;
  wire::Writer<wire::ServiceRequest> requests_;
  wire::Writer<wire::FaultInject> faults_;
  double fastest_joint_ = 0.0;
};

}  // namespace c3rt::test
