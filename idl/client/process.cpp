#include "idl/client/process.hpp"

#include <algorithm>
#include <cctype>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include <unistd.h>

#include "controller/base/time.hpp"
#include "controller/base/words.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/client/part.hpp"

namespace c3rt::client {
namespace {

constexpr int kDone = 0, kFailed = 1, kCouldNotStart = 2;  // as the processes end
constexpr double kOthers_s = 0.5;                          // in which another one is heard
constexpr double kTicks_s = 2.0;                  // until a plant in service has shown its ticks
constexpr std::int64_t kGone_ns = 3'000'000'000;  // without a plant the run is over
constexpr std::int64_t kForever_ns = std::numeric_limits<std::int64_t>::max() / 2;
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

wire::BusSettings bus_of(wire::Process process, const Place& place) {
  wire::BusSettings settings = bus_settings(place.domain, place.profile);
  settings.identity = wire::process_name(process);
  settings.clock = place.clock;
  settings.session_id = place.session;
  settings.shares_clock = true;
  return settings;
}

/// What a person calls who plays the process.
const char* a_role(wire::Process process) {
  switch (process) {
    case c3rt_v2_PROCESS_VISION:
      return "an estimator";
    case c3rt_v2_PROCESS_IMPEDANCE:
      return "a motion generator";
    default:
      return "a planner";
  }
}
/// The same without its article.
const char* role(wire::Process process) { return std::strchr(a_role(process), ' ') + 1; }

}  // namespace

Process::Part::Part(wire::Process process, const Place& place, const Pace& pace)
    : process_(process),
      place_(place),
      pace_(pace),
      bus_(bus_of(process, place)),
      endpoint_(bus_, process, {}, {}),
      ticks_(bus_, 1, wire::Wakes::kItself, process) {}

void Process::Part::run() {
  wire::Loop::Settings settings{process_, base::nanoseconds(1.0 / pace_.rate)};
  settings.join_timeout_ns = kForever_ns;
  settings.gone_timeout_ns = kGone_ns;
  settings.wakeup_latency = &endpoint_.status().wakeup_latency();
  loop_.emplace(bus_, settings);
  if (!await_place()) return;
  std::int64_t now_ns = 0;
  while (wait(now_ns)) {
    if (!lockstep() && ticks_.matched_writers() > 0) {
      began_ = false;
      throw WrongClock(
          base::words("the run is in lockstep, this %s in realtime: ClockMode::kLockstep, --clock "
                      "lockstep",
                      role(process_)));
    }
    overruns_ = loop_->missed_cycles();
    step(now_ns);
  }
  // in lockstep the run is over when the plant has left
  if (!loop_->failure().empty() && ticks_.alive_writers() > 0)
    throw wire::WireError(loop_->failure());
  endpoint_.say(c3rt_v2_SERVICE_STOPPING, "stopping");
}

bool Process::Part::wait(std::int64_t& now_ns) {
  if (lockstep() || !pace_.by_arrival) return loop_->wait(now_ns);
  bus_.wait_for_data(detail::kSlice_ns);
  now_ns = rt::now_ns();
  return !wire::StopFlag::requested();
}

bool Process::Part::await_place() {
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
          base::words("the run is in realtime, this %s in lockstep: ClockMode::kRealtime, --clock "
                      "realtime",
                      role(process_)));
    }
    serve(now_ns);
    bus_.wait_for_data(detail::kSlice_ns);
  }
  return false;
}

void Process::Part::require_nobody_else() {
  wire::ServiceStatus status{};
  while (statuses_.take(status)) {
    const bool serves =
        status.state == c3rt_v2_SERVICE_RUNNING || status.state == c3rt_v2_SERVICE_DEGRADED;
    if (!serves) continue;
    plant_heard_ = plant_heard_ || status.process == c3rt_v2_PROCESS_PLANT;
    if (status.process != process_ || status.pid == getpid()) continue;
    // of two that came in the same moment one stays
    if (in_service_ && status.pid > getpid()) continue;
    throw Occupied(base::words(
        "domain %u has %s already (pid %d): c3rt run|up --without %s leaves c3rt's own out",
        place_.domain, a_role(process_), status.pid, wire::process_name(process_)));
  }
}

void Process::Part::serve(std::int64_t now_ns) {
  endpoint_.serve_requests(now_ns, [this](c3rt_v2_RequestVerb verb) -> std::optional<wire::Answer> {
    return obey(verb);
  });
  endpoint_.serve_faults(now_ns, [](const wire::FaultInject&) {
    return std::string("a client plays this process, and it has no faults");
  });
}

Process::Process(wire::Process process) : process_(process) {}
Process::~Process() = default;

void Process::say(const std::string& text, bool degraded) {
  if (part_ == nullptr) return;
  part_->say(degraded ? c3rt_v2_SERVICE_DEGRADED : c3rt_v2_SERVICE_RUNNING, text);
}

void Process::run(const Place& place) {
  const StopBySignal signals;
  const std::unique_ptr<Part> part = take_part(place);
  part_ = part.get();
  const struct Leaving {
    Process& process;
    ~Leaving() {
      process.began_ = process.part_->began();
      process.part_ = nullptr;
    }
  } leaving{*this};
  try {
    part->run();
  } catch (const std::exception& error) {
    part->say(c3rt_v2_SERVICE_FAILED, error.what());
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

Place read_place(int argc, char** argv) {
  Place place;
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

int Process::main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) != "--help" && std::string(argv[i]) != "-h") continue;
    std::printf(
        "usage: %s [--domain N] [--profile NAME|FILE] [--clock realtime|lockstep] [--session N]\n"
        "In the place of c3rt-%s: c3rt run SCENARIO --without %s\n",
        argv[0], wire::process_name(process_), wire::process_name(process_));
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
