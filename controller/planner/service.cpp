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
  take_targets(now_ns);
  take_weights(now_ns);
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

void Service::take_targets(std::int64_t now_ns) {
  endpoint_.replies().answer_refused(targets_, now_ns);
  wire::TaskTarget sample{};
  while (targets_.take(sample)) {
    const std::string refused = take_target(sample);
    const std::string said = refused.empty() ? describe(in_.target) : "refused: " + refused;
    endpoint_.replies().answer(sample.request_id, refused.empty(), said, now_ns);
    endpoint_.tell(!refused.empty(), "target " + said);
  }
}

std::string Service::take_target(const wire::TaskTarget& sample) {
  try {
    Target target = load_target(wire::request(sample));
    if (auto* task = std::get_if<task::Task>(&target))
      *task = task->seeded(parameters_.sampling.seed);
    std::string refused = refusal(target, limits_);
    if (refused.empty()) in_.target = target;
    return refused;
  } catch (const task::RequestError& error) {
    return error.what();
  }
}

void Service::take_weights(std::int64_t now_ns) {
  endpoint_.replies().answer_refused(weighed_, now_ns);
  wire::PlannerWeights sample{};
  while (weighed_.take(sample)) {
    const NamedWeights wanted = wire::weights(sample);
    const std::string refused = take_weights(wanted);
    const std::string taken = wanted.empty() ? "the scenario's own" : describe(wanted);
    const std::string said = refused.empty() ? taken : "refused: " + refused;
    endpoint_.replies().answer(sample.request_id, refused.empty(), said, now_ns);
    endpoint_.tell(!refused.empty(), "weights " + said);
  }
}

std::string Service::take_weights(const NamedWeights& wanted) {
  const std::string refused = refusal(wanted, adjustable_);
  if (!refused.empty()) return refused;
  NamedWeights together;
  if (!wanted.empty()) {
    together = wanted;
    together.insert(weights_.begin(), weights_.end());  // where both name one, it is the wanted
  }
  node_.set_weights(with_weights(parameters_, together));
  weights_ = together;
  return "";
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
