#include "idl/client/planner.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>

#include <unistd.h>

#include "controller/base/time.hpp"
#include "controller/base/words.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/endpoint.hpp"

namespace c3rt::client {
namespace {

constexpr int kDone = 0, kFailed = 1, kCouldNotStart = 2;  // as the processes end
constexpr double kOthers_s = 0.5;                          // in which another planner is heard
constexpr double kTicks_s = 2.0;                  // until a plant in service has shown its ticks
constexpr std::int64_t kGone_ns = 3'000'000'000;  // without a plant the run is over
constexpr std::int64_t kForever_ns = std::numeric_limits<std::int64_t>::max() / 2;
constexpr int kQueue = 64;
constexpr const char* kWaiting = "waiting for the robot's state";

/// While it lives, SIGINT and SIGTERM ask for a stop; then they do what they did before.
class StopBySignal {
 public:
  StopBySignal() {
    sigaction(SIGINT, nullptr, &interrupt_);
    sigaction(SIGTERM, nullptr, &terminate_);
    wire::StopFlag::clear();
    const wire::StopFlag flag;
  }
  ~StopBySignal() {
    wire::StopFlag::clear();
    sigaction(SIGINT, &interrupt_, nullptr);
    sigaction(SIGTERM, &terminate_, nullptr);
  }
  StopBySignal(const StopBySignal&) = delete;
  StopBySignal& operator=(const StopBySignal&) = delete;

 private:
  struct sigaction interrupt_ {};
  struct sigaction terminate_ {};
};

wire::BusSettings bus_of(const PlannerPlace& place) {
  wire::BusSettings settings = bus_settings(place.domain, place.profile);
  settings.identity = wire::process_name(c3rt_v2_PROCESS_PLANNER);
  settings.clock = place.clock;
  settings.session_id = place.session;
  settings.shares_clock = true;
  return settings;
}

wire::Loop::Settings pace(double rate, wire::StatusReporter& status) {
  wire::Loop::Settings settings{c3rt_v2_PROCESS_PLANNER, base::nanoseconds(1.0 / rate)};
  settings.join_timeout_ns = kForever_ns;
  settings.gone_timeout_ns = kGone_ns;
  settings.wakeup_latency = &status.wakeup_latency();
  return settings;
}

}  // namespace

/// One run().
class Planner::Part {
 public:
  Part(Planner& planner, const PlannerPlace& place)
      : planner_(planner), place_(place), bus_(bus_of(place)) {}

  void run();
  void say(c3rt_v2_ServiceState state, const std::string& text) { endpoint_.say(state, text); }

 private:
  bool lockstep() const { return place_.clock == wire::ClockMode::kLockstep; }
  /// Until the plant's clock is known. @return false after a stop
  bool await_place();
  void require_nobody_else();
  void step(std::int64_t now_ns);
  void take(std::int64_t now_ns);
  void serve(std::int64_t now_ns);
  Motion motion(const Situation& now);

  Planner& planner_;
  const PlannerPlace place_;
  wire::Bus bus_;
  wire::Endpoint endpoint_{bus_, c3rt_v2_PROCESS_PLANNER, {}, {}};
  wire::Reader<wire::RobotState> states_{bus_, kQueue};
  wire::Reader<wire::ObjectEstimate> estimates_{bus_, kQueue};
  wire::Reader<wire::TaskTarget> targets_{bus_, kQueue};
  wire::Reader<wire::ServiceStatus> statuses_{bus_, kQueue};
  // looked at, never taken from: who writes ticks is in lockstep
  wire::Reader<wire::Tick> ticks_{bus_, 1, wire::Wakes::kItself, c3rt_v2_PROCESS_PLANNER};
  wire::Writer<wire::Plan> plans_{bus_};
  wire::Loop loop_{bus_, pace(planner_.settings_.rate, endpoint_.status())};
  std::atomic<std::uint64_t>& sent_ = endpoint_.status().counter("plans");
  std::atomic<std::uint64_t>& overruns_ = endpoint_.status().counter("overruns");

  Observations observed_;
  bool plant_heard_ = false;  // in service
  bool in_service_ = false;   // this planner
  bool stopped_ = false;
  std::optional<Vector> held_;  // where the arm was when it was stopped
};

void Planner::Part::run() {
  if (!await_place()) return;
  std::int64_t now_ns = 0;
  while (loop_.wait(now_ns)) {
    if (!lockstep() && ticks_.matched_writers() > 0) {
      planner_.began_ = false;
      throw WrongClock(
          "the run is in lockstep, this planner in realtime: ClockMode::kLockstep, --clock "
          "lockstep");
    }
    overruns_ = loop_.missed_cycles();
    step(now_ns);
  }
  // in lockstep the run is over when the plant has left
  if (!loop_.failure().empty() && ticks_.alive_writers() > 0)
    throw wire::WireError(loop_.failure());
  endpoint_.say(c3rt_v2_SERVICE_STOPPING, "stopping");
}

bool Planner::Part::await_place() {
  const std::int64_t others_ns = detail::after(kOthers_s);
  const std::int64_t settled_ns = detail::after(2.0 * kOthers_s);
  std::int64_t patience_ns = kForever_ns;  // for ticks of a plant that is in service
  while (!wire::StopFlag::requested()) {
    require_nobody_else();
    const std::int64_t now_ns = rt::now_ns();
    if (now_ns > others_ns) {
      in_service_ = true;
      endpoint_.say(c3rt_v2_SERVICE_RUNNING, kWaiting);
    }
    if (now_ns > settled_ns) {
      if (!lockstep() || ticks_.matched_writers() > 0) return true;
      if (plant_heard_) patience_ns = std::min(patience_ns, detail::after(kTicks_s));
    }
    if (now_ns > patience_ns) {
      throw WrongClock(
          "the run is in realtime, this planner in lockstep: ClockMode::kRealtime, --clock "
          "realtime");
    }
    serve(now_ns);
    bus_.wait_for_data(detail::kSlice_ns);
  }
  return false;
}

void Planner::Part::require_nobody_else() {
  wire::ServiceStatus status{};
  while (statuses_.take(status)) {
    const bool serves =
        status.state == c3rt_v2_SERVICE_RUNNING || status.state == c3rt_v2_SERVICE_DEGRADED;
    if (!serves) continue;
    plant_heard_ = plant_heard_ || status.process == c3rt_v2_PROCESS_PLANT;
    if (status.process != c3rt_v2_PROCESS_PLANNER || status.pid == getpid()) continue;
    // of two that came in the same moment one stays
    if (in_service_ && status.pid > getpid()) continue;
    throw Occupied(
        base::words("domain %u has a planner already (pid %d): c3rt run|up --without "
                    "planner leaves c3rt's own out",
                    place_.domain, status.pid));
  }
}

void Planner::Part::step(std::int64_t now_ns) {
  take(now_ns);
  serve(now_ns);
  if (!observed_.has_state()) return;
  planner_.began_ = true;
  const std::int64_t begin_ns = rt::now_ns();
  const Motion planned = motion(observed_.situation(now_ns));
  const double solve_time = base::seconds(rt::now_ns() - begin_ns);
  endpoint_.status().compute().add(solve_time);
  if (planned.knots.empty()) return;
  std::int64_t effective_ns = now_ns + base::nanoseconds(planner_.settings_.delay);
  if (!lockstep()) effective_ns = std::max(effective_ns, rt::now_ns());
  wire::Plan plan = plan_sample(planned, effective_ns, planner_.settings_.valid_for);
  plan.origin = observed_.origin();
  plan.solve_time_s = lockstep() ? 0.0 : solve_time;
  if (plans_.write(plan, effective_ns)) ++sent_;
}

Motion Planner::Part::motion(const Situation& now) {
  if (stopped_) {
    if (!held_) held_ = now.effector.p;
    return {{{*held_}}, "hold"};
  }
  held_.reset();
  return planner_.plan(now);
}

void Planner::Part::take(std::int64_t now_ns) {
  const bool first = !observed_.has_state();
  wire::RobotState state{};
  while (states_.take_next_effective(now_ns, state)) observed_.add(state);
  wire::ObjectEstimate estimate{};
  while (estimates_.take_next_effective(now_ns, estimate)) observed_.add(estimate);
  if (first && observed_.has_state()) endpoint_.say(c3rt_v2_SERVICE_RUNNING, "plans");
}

void Planner::Part::serve(std::int64_t now_ns) {
  endpoint_.replies().answer_refused(targets_, now_ns);
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
    endpoint_.replies().answer(target.request_id, refused.empty(),
                               refused.empty() ? target.kind : refused, now_ns);
  }
  endpoint_.serve_requests(now_ns, [this](c3rt_v2_RequestVerb verb) -> std::optional<wire::Answer> {
    stopped_ = verb == c3rt_v2_REQUEST_STOP;  // or it is to recover
    return wire::Answer{true, stopped_ ? "holding until recover" : "goes on"};
  });
  endpoint_.serve_faults(now_ns, [](const wire::FaultInject&) {
    return std::string("a client plays this process, and it has no faults");
  });
}

Planner::Planner(const PlannerSettings& settings) : settings_(settings) {
  const auto require = [](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw std::invalid_argument(
        base::words("%s: expected %g to %g, got %g", name, low, high, value));
  };
  require("rate", settings.rate, 1.0, 1000.0);
  require("delay", settings.delay, 0.0, 1.0);
  require("valid_for", settings.valid_for, 0.001, 10.0);
}

Planner::~Planner() = default;

void Planner::target(const std::string&, const std::vector<Parameter>&) {
  throw std::invalid_argument("a client plays the planner, and it takes no targets");
}

void Planner::say(const std::string& text, bool degraded) {
  if (part_ == nullptr) return;
  part_->say(degraded ? c3rt_v2_SERVICE_DEGRADED : c3rt_v2_SERVICE_RUNNING, text);
}

void Planner::run(const PlannerPlace& place) {
  const StopBySignal signals;
  Part part(*this, place);
  part_ = &part;
  const struct Leaving {
    Part*& part;
    ~Leaving() { part = nullptr; }
  } leaving{part_};
  try {
    part.run();
  } catch (const std::exception& error) {
    part.say(c3rt_v2_SERVICE_FAILED, error.what());
    throw;
  }
}

namespace {

/// The value of a word "--name=value" or "--name value"; nothing where it is another option.
std::optional<std::string> value_of(const char* name, int argc, char** argv, int& i) {
  const std::string word = argv[i], option = std::string("--") + name;
  if (word.rfind(option + "=", 0) == 0) return word.substr(option.size() + 1);
  if (word != option) return std::nullopt;
  if (i + 1 == argc) throw std::invalid_argument(option + ": expected a value after it");
  return argv[++i];
}

std::uint64_t number(const char* name, const std::string& text) {
  const bool digits = !text.empty() && text.size() < 20 &&
                      std::all_of(text.begin(), text.end(),
                                  [](unsigned char letter) { return std::isdigit(letter) != 0; });
  if (!digits) {
    throw std::invalid_argument(std::string("--") + name +
                                ": expected a whole number from 0, got \"" + text + "\"");
  }
  return std::strtoull(text.c_str(), nullptr, 10);
}

wire::ClockMode clock_of(const std::string& text) {
  if (text == "lockstep") return wire::ClockMode::kLockstep;
  if (text == "realtime") return wire::ClockMode::kRealtime;
  throw std::invalid_argument("--clock: expected realtime or lockstep, got \"" + text + "\"");
}

PlannerPlace read_place(int argc, char** argv) {
  PlannerPlace place;
  for (int i = 1; i < argc; ++i) {
    if (const auto domain = value_of("domain", argc, argv, i)) {
      place.domain = static_cast<std::uint32_t>(
          std::min<std::uint64_t>(number("domain", *domain), std::uint32_t(-1)));
    } else if (const auto session = value_of("session", argc, argv, i)) {
      place.session = number("session", *session);
    } else if (const auto clock = value_of("clock", argc, argv, i)) {
      place.clock = clock_of(*clock);
    } else if (const auto profile = value_of("profile", argc, argv, i)) {
      place.profile = *profile;
    } else if (const auto file = value_of("dds-profile", argc, argv, i)) {
      place.profile = *file;
    } else if (value_of("seed", argc, argv, i) || value_of("set", argc, argv, i)) {
      // what c3rt gives its own processes, and this one has no use for
    } else if (argv[i][0] == '-') {
      throw std::invalid_argument(std::string(argv[i]) + ": no option of this program");
    }  // the scenario
  }
  return place;
}

}  // namespace

int Planner::main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) != "--help" && std::string(argv[i]) != "-h") continue;
    std::printf(
        "usage: %s [--domain N] [--profile NAME|FILE] [--clock realtime|lockstep] [--session N]\n"
        "A planner in the place of c3rt-planner: c3rt run SCENARIO --without planner\n",
        argv[0]);
    return kDone;
  }
  began_ = false;
  try {
    run(read_place(argc, argv));
    return kDone;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: error: %s\n", argv[0], error.what());
  }
  return began_ ? kFailed : kCouldNotStart;
}

}  // namespace c3rt::client
