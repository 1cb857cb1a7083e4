#include "idl/client/planner.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/client/part.hpp"
#include "idl/client/settings.hpp"

namespace c3rt::client {

/// One run().
class Planner::Planning final : public Process::Part {
 public:
  Planning(Planner& planner, const Place& place)
      : Part(c3rt_v2_PROCESS_PLANNER, place, {planner.settings_.rate}), planner_(planner) {}

 private:
  void step(std::int64_t now_ns) override;
  void serve(std::int64_t now_ns) override;
  wire::Answer obey(c3rt_v2_RequestVerb verb) override {
    stopped_ = verb == c3rt_v2_REQUEST_STOP;  // or it is to recover
    return {true, stopped_ ? "holding until recover" : "goes on"};
  }
  void take(std::int64_t now_ns);
  Motion motion(const Situation& now);

  Planner& planner_;
  wire::Reader<wire::RobotState> states_{bus(), kQueue};
  wire::Reader<wire::ObjectEstimate> estimates_{bus(), kQueue};
  wire::Reader<wire::TaskTarget> targets_{bus(), kQueue};
  wire::Writer<wire::Plan> plans_{bus()};
  std::atomic<std::uint64_t>& sent_ = endpoint().status().counter("plans");
  Observations observed_;
  bool stopped_ = false;
  std::optional<Vector> held_;  // where the arm was when it was stopped
};

void Planner::Planning::step(std::int64_t now_ns) {
  take(now_ns);
  serve(now_ns);
  if (!observed_.has_state()) return;
  begin();
  const std::int64_t begin_ns = rt::now_ns();
  const Motion planned = motion(observed_.situation(now_ns));
  const double solve_time = base::seconds(rt::now_ns() - begin_ns);
  endpoint().status().compute().add(solve_time);
  if (planned.knots.empty()) return;
  std::int64_t effective_ns = now_ns + base::nanoseconds(planner_.settings_.delay);
  if (!lockstep()) effective_ns = std::max(effective_ns, rt::now_ns());
  wire::Plan plan = plan_sample(planned, effective_ns, planner_.settings_.valid_for);
  plan.origin = observed_.origin();
  plan.solve_time_s = lockstep() ? 0.0 : solve_time;
  if (plans_.write(plan, effective_ns)) ++sent_;
}

Motion Planner::Planning::motion(const Situation& now) {
  if (stopped_) {
    if (!held_) held_ = now.effector.p;
    return {{{*held_}}, "hold"};
  }
  held_.reset();
  return planner_.plan(now);
}

void Planner::Planning::take(std::int64_t now_ns) {
  const bool first = !observed_.has_state();
  wire::RobotState state{};
  while (states_.take_next_effective(now_ns, state)) observed_.add(state);
  wire::ObjectEstimate estimate{};
  while (estimates_.take_next_effective(now_ns, estimate)) observed_.add(estimate);
  if (first && observed_.has_state()) say(c3rt_v2_SERVICE_RUNNING, "plans");
}

void Planner::Planning::serve(std::int64_t now_ns) {
  endpoint().replies().answer_refused(targets_, now_ns);
  wire::TaskTarget target{};
  while (targets_.take(target)) {
    std::vector<Parameter> parameters;
    for (int i = 0; i < target.parameter_count; ++i) {
      const c3rt_v2_TargetParameter& given = target.parameters[i];
      parameters.push_back(
          {given.name, {given.values, given.values + given.value_count}, given.word});
    }
    std::string refused;
    try {
      planner_.target(target.kind, parameters);
    } catch (const std::invalid_argument& error) {
      refused = std::string("refused: ") + error.what();
    }
    endpoint().replies().answer(target.request_id, refused.empty(),
                                refused.empty() ? target.kind : refused, now_ns);
  }
  Part::serve(now_ns);
}

Planner::Planner(const PlannerSettings& settings)
    : Process(c3rt_v2_PROCESS_PLANNER), settings_(settings) {
  require_within("rate", settings.rate, 1.0, 1000.0);
  require_within("delay", settings.delay, 0.0, 1.0);
  require_within("valid_for", settings.valid_for, 0.001, 10.0);
}

// not inline: the vtable is the package's
Planner::~Planner() = default;

void Planner::target(const std::string&, const std::vector<Parameter>&) {
  throw std::invalid_argument("a client plays the planner, and it takes no targets");
}

std::unique_ptr<Process::Part> Planner::take_part(const Place& place) {
  return std::make_unique<Planning>(*this, place);
}

}  // namespace c3rt::client
