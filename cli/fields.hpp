#pragma once
// The fields of a sample as a person wants to see them: those of the contract, but for types that
// are made to be filled and not to be read.
#include "idl/topics.hpp"

namespace c3rt::cli {

using wire::name_of;  // a person reads names, a log numbers

/// A visitor is called with (name, value), where a value is a number, an enumerator, an array or
/// text. `list` gets the used part of an array.
template <typename T, typename Visitor>
void visit_sample(const T& sample, Visitor& visit) {
  wire::visit_fields(sample, visit);
}

template <typename Visitor>
void visit_sample(const wire::Plan& s, Visitor& visit) {
  visit("header", s.header);
  visit("robot", s.robot);
  visit("origin", s.origin);
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
void visit_sample(const wire::ServiceStatus& s, Visitor& visit) {
  visit("header", s.header);
  visit("process", s.process);
  visit("pid", s.pid);
  visit("state", s.state);
  visit("text", s.text);
  visit("rate_hz", s.rate_hz);
  visit("wakeup_latency_p50_s", s.wakeup_latency.p50_s);
  visit("wakeup_latency_p99_s", s.wakeup_latency.p99_s);
  visit("wakeup_latency_max_s", s.wakeup_latency.max_s);
  visit("compute_p50_s", s.compute.p50_s);
  visit("compute_p99_s", s.compute.p99_s);
  visit("compute_max_s", s.compute.max_s);
  for (int i = 0; i < c3rt_v2_COUNTERS && s.counter_names[i][0] != '\0'; ++i)
    visit(s.counter_names[i], s.counters[i]);
  visit.list("refused", s.refused, wire::refused_kinds(s));
}

}  // namespace c3rt::cli
