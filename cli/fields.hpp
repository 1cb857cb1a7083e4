#pragma once
// Every field of every type, named once: the log's columns, its hash and `c3rt echo` all come from
// here.
#include <string>
#include <type_traits>

#include "idl/topics.hpp"

namespace c3rt::cli {

/// A visitor is called with (name, value), where a value is a number, an enumerator, an array or
/// text. `matrix` and `list` get the used part of an array that is larger than most samples need.
template <typename Visitor>
void visit_origin(const wire::Origin& origin, Visitor& visit) {
  visit("exposure_ns", origin.exposure_ns);
  visit("estimate_ns", origin.estimate_ns);
  visit("state_ns", origin.state_ns);
  visit("plan_ns", origin.plan_ns);
}

template <typename Visitor>
void visit_fields(const wire::RobotState& s, Visitor& visit) {
  visit("robot", s.robot);
  visit("q_rad", s.q_rad);
  visit("dq_rad_per_s", s.dq_rad_per_s);
  visit("tau_nm", s.tau_nm);
  visit("p_WE_m", s.p_WE_m);
  visit("q_WE", s.q_WE);
  visit("mode", s.mode);
  visit("errors", s.errors);
  visit("command_success_rate", s.command_success_rate);
  visit("command_seq", s.command_seq);
  visit("command_state_ns", s.command_state_ns);
}

template <typename Visitor>
void visit_fields(const wire::RobotCommand& s, Visitor& visit) {
  visit("robot", s.robot);
  visit_origin(s.origin, visit);
  visit("tau_nm", s.tau_nm);
  visit("mode", s.mode);
  visit("p_WE_desired_m", s.p_WE_desired_m);
  visit("v_WE_desired_m_per_s", s.v_WE_desired_m_per_s);
}

template <typename Visitor>
void visit_fields(const wire::Plan& s, Visitor& visit) {
  visit("robot", s.robot);
  visit_origin(s.origin, visit);
  visit("valid_until_ns", s.valid_until_ns);
  visit("status", s.status);
  visit("phase", s.phase);
  visit("p_WE_desired_m", s.p_WE_desired_m);
  visit("v_WE_desired_m_per_s", s.v_WE_desired_m_per_s);
  visit("q_WE_desired", s.q_WE_desired);
  visit("force_E_n", s.force_E_n);
  visit("ball_target_m", s.ball_target_m);
  visit("delta_t_c_s", s.delta_t_c_s);
  visit.machine_time("solve_time_s", s.solve_time_s);
  visit("admm_iterations", s.admm_iterations);
  visit("complementarity_violation", s.complementarity_violation);
  visit("u_c3", s.u_c3);
  visit.matrix("lambda_d", &s.lambda_d, 1, s.n_lambda);
  visit.matrix("primal_residual", &s.primal_residual, 1, s.admm_iterations);
  visit.matrix("x", s.x, s.N, s.n_x);
  visit.matrix("lambda", s.lambda, s.N, s.n_lambda);
  visit.matrix("u", s.u, s.N, s.n_u);
}

template <typename Visitor>
void visit_fields(const wire::BallDetection& s, Visitor& visit) {
  visit("camera", s.camera);
  visit("ball", s.ball);
  visit("exposure_ns", s.exposure_ns);
  visit("found", s.found);
  visit("used", s.used);
  visit("u_px", s.u_px);
  visit("v_px", s.v_px);
  visit("radius_px", s.radius_px);
  visit("p_WB_m", s.p_WB_m);
}

template <typename Visitor>
void visit_fields(const wire::BallEstimate& s, Visitor& visit) {
  visit("ball", s.ball);
  visit("exposure_ns", s.exposure_ns);
  visit("valid", s.valid);
  visit("cameras_used", s.cameras_used);
  visit("p_measured_m", s.p_measured_m);
  visit("p_WB_m", s.p_WB_m);
  visit("v_WB_m_per_s", s.v_WB_m_per_s);
  visit("omega_rad_per_s", s.omega_rad_per_s);
  visit("q_WB", s.q_WB);
}

template <typename Visitor>
void visit_fields(const wire::Scene& s, Visitor& visit) {
  visit("exposure", s.exposure);
  visit("q_rad", s.q_rad);
  visit("p_WE_m", s.p_WE_m);
  visit("ball_count", s.ball_count);
  visit("p_WB_m", s.p_WB_m);
  visit("q_WB", s.q_WB);
  visit("v_WB_m_per_s", s.v_WB_m_per_s);
  visit("omega_rad_per_s", s.omega_rad_per_s);
}

template <typename Visitor>
void visit_fields(const wire::TaskTarget& s, Visitor& visit) {
  visit("request_id", s.request_id);
  visit("kind", s.kind);
  visit("center_m", s.center_m);
  visit("radius_m", s.radius_m);
  visit("lead_rad", s.lead_rad);
}

template <typename Visitor>
void visit_fields(const wire::Tick& s, Visitor& visit) {
  visit("due", s.due);
  visit("newest_seq", s.newest_seq);
}

template <typename Visitor>
void visit_fields(const wire::Done& s, Visitor& visit) {
  visit("process", s.process);
  visit("next_due_ns", s.next_due_ns);
  visit("newest_seq", s.newest_seq);
}

template <typename Visitor>
void visit_quantiles(const char* p50, const char* p99, const char* max, const wire::Quantiles& q,
                     Visitor& visit) {
  visit(p50, q.p50_s);
  visit(p99, q.p99_s);
  visit(max, q.max_s);
}

template <typename Visitor>
void visit_fields(const wire::ServiceStatus& s, Visitor& visit) {
  visit("process", s.process);
  visit("pid", s.pid);
  visit("state", s.state);
  visit("text", s.text);
  visit("rate_hz", s.rate_hz);
  visit_quantiles("wakeup_latency_p50_s", "wakeup_latency_p99_s", "wakeup_latency_max_s",
                  s.wakeup_latency, visit);
  visit_quantiles("compute_p50_s", "compute_p99_s", "compute_max_s", s.compute, visit);
  for (int i = 0; i < c3rt_v2_COUNTERS && s.counter_names[i][0] != '\0'; ++i)
    visit(s.counter_names[i], s.counters[i]);
  visit.list("refused", s.refused, wire::refused_kinds(s));
}

template <typename Visitor>
void visit_fields(const wire::ServiceRequest& s, Visitor& visit) {
  visit("request_id", s.request_id);
  visit("process", s.process);
  visit("verb", s.verb);
}

template <typename Visitor>
void visit_fields(const wire::ServiceReply& s, Visitor& visit) {
  visit("request_id", s.request_id);
  visit("process", s.process);
  visit("ok", s.ok);
  visit("text", s.text);
}

template <typename Visitor>
void visit_fields(const wire::FaultInject& s, Visitor& visit) {
  visit("process", s.process);
  visit("request_id", s.request_id);
  visit("kind", s.kind);
  visit("index", s.index);
  visit("duration_s", s.duration_s);
  visit("value", s.value);
}

/// Calls `action` with a default sample of every type, in the order of the topic table.
template <typename Action>
void for_each_topic(Action&& action) {
  action(wire::RobotState{});
  action(wire::RobotCommand{});
  action(wire::Plan{});
  action(wire::BallDetection{});
  action(wire::BallEstimate{});
  action(wire::TaskTarget{});
  action(wire::Scene{});
  action(wire::Tick{});
  action(wire::Done{});
  action(wire::ServiceStatus{});
  action(wire::ServiceRequest{});
  action(wire::ServiceReply{});
  action(wire::FaultInject{});
}

/// Calls `action` with a default sample of the topic's type. @return false if there is no topic of
/// this name
template <typename Action>
bool with_topic(const std::string& name, Action&& action) {
  bool found = false;
  for_each_topic([&](const auto& sample) {
    if (name != wire::topic<std::decay_t<decltype(sample)>>().name) return;
    found = true;
    action(sample);
  });
  return found;
}

// a person reads names, a log numbers
const char* name_of(c3rt_v1_RobotMode value);
const char* name_of(c3rt_v1_ImpedanceMode value);
const char* name_of(c3rt_v1_PlanStatus value);
const char* name_of(c3rt_v1_PlanPhase value);
const char* name_of(c3rt_v1_TargetKind value);
const char* name_of(c3rt_v1_ServiceState value);
const char* name_of(c3rt_v1_RequestVerb value);
const char* name_of(c3rt_v1_FaultKind value);
inline const char* name_of(c3rt_v1_Process value) { return wire::process_name(value); }

}  // namespace c3rt::cli
