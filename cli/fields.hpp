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
