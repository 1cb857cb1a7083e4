#include "controller/planner/service.hpp"

#include <optional>
#include <utility>

#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/convert.hpp"

namespace c3rt::planner {

using base::seconds;

Service::Service(wire::Bus& bus, wire::Endpoint& endpoint, const Parameters& parameters,
                 model::Arm arm, double solve_time)
    : endpoint_(endpoint),
      parameters_(parameters),
      limits_(target_limits(parameters)),
      adjustable_(adjustable_weights(parameters)),
      pool_(parameters.sampling.threads),
      node_(parameters, std::move(arm),
            {&rt::now_ns, bus.clock() == wire::ClockMode::kRealtime, solve_time},
            {&rt::WorkerPool::run_on, &pool_, pool_.workers()}),
      states_(bus),
      commands_(bus),
      estimates_(bus),
      targets_(bus),
      weighed_(bus),
      plans_(bus),
      debug_(bus),
      sent_(endpoint.status().counter("plans")),
      overruns_(endpoint.status().counter("overruns")),
      truncated_(endpoint.status().counter("truncated")),
      fallbacks_(endpoint.status().counter("fallbacks")),
      object_lost_(endpoint.status().counter("object_lost")),
      failures_(endpoint.status().counter("failures")) {
  endpoint_.say(c3rt_v2_SERVICE_RUNNING, "waiting for the robot's state");
}

void Service::step(std::int64_t now_ns) {
  take(now_ns);
  take_asked(targets_, "target", now_ns,
             [this](const wire::TaskTarget& sample) { return take_target(sample); });
  take_asked(weighed_, "weights", now_ns,
             [this](const wire::PlannerWeights& sample) { return take_weights(sample); });
  serve_clients(now_ns);
  if (faults_.stalls(now_ns)) return;

  in_.spoilt = faults_.spoils(now_ns);
  Node::Output out = node_.step(now_ns, in_);
  endpoint_.status().compute().add(out.measured);
  if (out.measured > 1.0 / parameters_.rate) ++overruns_;
  if (out.plans) {
    plans_.write(out.plan, out.effective_ns);
    out.debug.plan_seq = out.plan.header.seq;
    debug_.write(out.debug, out.effective_ns);
    ++sent_;
  }
  const Planner::Counters& counters = node_.planner().counters();
  truncated_ = counters.truncated;
  fallbacks_ = counters.fallbacks;
  object_lost_ = counters.body_lost;
  // told again only where another thing was thrown: it may be thrown in every period
  if (counters.failures != failures_ && failure_ != node_.planner().failure()) {
    failure_ = node_.planner().failure();
    endpoint_.tell(true, "a period failed, the end effector is held: " + failure_);
  }
  failures_ = counters.failures;
  tell(seconds(now_ns));
}

void Service::take(std::int64_t now_ns) {
  in_.has_state |= states_.take_effective(now_ns, in_.state);
  commands_.take_effective(now_ns, in_.command);
  wire::ObjectEstimate estimate{};
  while (estimates_.take_next_effective(now_ns, estimate)) {
    // what strangers write is checked: an object that the scenario does not have is nobody's
    if (estimate.object_index >= 0 && estimate.object_index < parameters_.model.bodies)
      in_.objects[static_cast<std::size_t>(estimate.object_index)] = estimate;
  }
}

template <typename T, typename Take>
void Service::take_asked(wire::Reader<T>& reader, const char* what, std::int64_t now_ns,
                         Take&& take) {
  endpoint_.replies().answer_refused(reader, now_ns);
  T sample{};
  while (reader.take(sample)) {
    const wire::Answer answer = take(sample);
    const std::string said = answer.ok ? answer.text : "refused: " + answer.text;
    endpoint_.replies().answer(sample.request_id, answer.ok, said, now_ns);
    endpoint_.tell(!answer.ok, std::string(what) + " " + said);
  }
}

wire::Answer Service::take_target(const wire::TaskTarget& sample) {
  try {
    Target target = load_target(wire::request(sample));
    if (auto* task = std::get_if<task::Task>(&target))
      *task = task->seeded(parameters_.sampling.seed);
    const std::string refused = refusal(target, limits_);
    if (!refused.empty()) return {false, refused};
    in_.target = target;
    return {true, describe(target)};
  } catch (const task::RequestError& error) {
    return {false, error.what()};
  }
}

wire::Answer Service::take_weights(const wire::PlannerWeights& sample) {
  const NamedWeights wanted = wire::weights(sample);
  const std::string refused = refusal(wanted, adjustable_);
  if (!refused.empty()) return {false, refused};
  NamedWeights together = wanted;
  // where both name one, it is the wanted; none at all: the scenario's
  if (!wanted.empty()) together.insert(weights_.begin(), weights_.end());
  node_.set_weights(with_weights(parameters_, together));
  weights_ = together;
  return {true, wanted.empty() ? "the scenario's own" : describe(wanted)};
}

void Service::serve_clients(std::int64_t now_ns) {
  endpoint_.serve_requests(now_ns, [this](c3rt_v2_RequestVerb verb) -> std::optional<wire::Answer> {
    in_.stopped = verb == c3rt_v2_REQUEST_STOP;  // or it is to recover
    return wire::Answer{
        true, in_.stopped ? "holding until recover" : "planning: " + describe(in_.target)};
  });
  endpoint_.serve_faults(now_ns, [this, now_ns](const wire::FaultInject& fault) {
    faults_.begin(fault, now_ns);
    return std::string();
  });
}

/// What the planner is doing, in its status; and in the log where that is not its ordinary work.
void Service::tell(double now) {
  const Activity& activity = node_.planner().activity();
  const std::string text = describe(activity, parameters_, now);
  const bool degraded = needs_attention(activity);
  if (!endpoint_.say(degraded ? c3rt_v2_SERVICE_DEGRADED : c3rt_v2_SERVICE_RUNNING, text)) return;
  // a cause is told once, though its numbers go on
  const bool new_cause = activity.cause != told_.cause || activity.body != told_.body;
  const bool at_rest = activity.cause != Cause::kNone && activity.mode != told_.mode;
  if (new_cause || at_rest) endpoint_.tell(false, text);
  told_ = activity;
}

std::string Service::summary() const {
  const Planner::Counters& counters = node_.planner().counters();
  return "plans=" + std::to_string(sent_) + " truncated=" + std::to_string(counters.truncated) +
         " fallbacks=" + std::to_string(counters.fallbacks) +
         " object_lost=" + std::to_string(counters.body_lost) +
         " lcp_failures=" + std::to_string(counters.lcp_failures) +
         " speed_clamped=" + std::to_string(counters.speed_clamped) +
         " failures=" + std::to_string(counters.failures);
}

}  // namespace c3rt::planner
