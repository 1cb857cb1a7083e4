#include "cli/launch.hpp"

#include <algorithm>
#include <ctime>
#include <iterator>
#include <set>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include "cli/guests.hpp"
#include "cli/keys/keystore.hpp"
#include "cli/neighbours.hpp"
#include "cli/paths.hpp"
#include "idl/process.hpp"
#include "idl/security.hpp"

namespace c3rt::cli {
namespace fs = std::filesystem;
namespace {

constexpr int kTailLines = 15;
constexpr double kLookWithKeys = 2.5;  // for neighbours [s]
constexpr const char* kProcesses[] = {"plant", "impedance", "planner", "vision"};

wire::BusSettings bus_settings(const LaunchSettings& settings) {
  wire::BusSettings bus;
  bus.domain = settings.domain;
  bus.profile_uri = dds_profile_path(settings.dds_profile).string();
  if (!settings.in_process) keys::require_keys(bus.profile_uri, keys::identity_names());
  bus.clock = settings.lockstep ? wire::ClockMode::kLockstep : wire::ClockMode::kRealtime;
  bus.session_id = settings.session != 0 ? settings.session : wire::draw_session();
  // the session is the plant's to draw: the others take it from there
  if (settings.leaves_out("plant")) bus.session_id = 0;
  return bus;
}

Instance instance(const LaunchSettings& settings, const std::string& scenario, const fs::path& file,
                  const wire::BusSettings& bus, const fs::path& out) {
  Instance self;
  self.pid = getpid();
  self.verb = settings.verb;
  self.scenario = scenario;
  self.file = fs::absolute(file).string();
  self.overrides = settings.overrides;
  self.clock = settings.clock_name();
  self.session = bus.session_id;
  self.seed = settings.seed;
  self.profile = bus.profile_uri;
  self.out = out.string();
  self.started = fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::localtime(std::time(nullptr)));
  return self;
}

}  // namespace

Launch::Launch(const LaunchSettings& settings)
    : settings_(settings),
      file_(scenario_path(settings.scenario)),
      scenario_(config::load_scenario(file_.string(), settings.overrides)),
      out_(
          fs::absolute(settings.out.empty() ? new_folder(scenario_.name) : fs::path(settings.out))),
      bus_(bus_settings(settings)) {
  if (settings.in_process) {
    bus_.exchange = wire::make_exchange();
  } else {
    lock_domain();
  }
  make_folder(out_ / "logs");
  require_room(out_ / "logs");
}

void Launch::lock_domain() {
  const Instance self = instance(settings_, scenario_.name, file_, bus_, out_);
  lock_ = settings_.any_domain
              ? lock_any_domain(runtime_directory(), self)
              : std::make_unique<DomainLock>(runtime_directory(), settings_.domain, self);
  bus_.domain = lock_->domain();
  for (const char* name : kProcesses) {
    if (leaves_out(name)) continue;
    const fs::path program = process_directory() / (std::string("c3rt-") + name);
    if (access(program.c_str(), X_OK) != 0)
      throw UsageError("there is no program " + program.string());
  }
}

void Launch::require_free_bus() const {
  wire::BusSettings look = bus_;
  look.clock = wire::ClockMode::kRealtime;
  look.session_id = 0;
  wire::Bus bus(look);
  // with keys two participants know each other later
  const bool secure = wire::is_secure(read_text(look.profile_uri));
  const double seconds = secure ? kLookWithKeys : kLookForNeighbours;
  // a domain that was drawn is silent already
  std::vector<Neighbour> others =
      settings_.any_domain ? std::vector<Neighbour>() : neighbours(bus, seconds);
  if (!others.empty() && !settings_.without.empty()) {
    const std::set<int> guests = guests_on(bus, settings_.without, seconds);
    const auto is_guest = [&guests](const Neighbour& other) { return guests.count(other.pid) > 0; };
    others.erase(std::remove_if(others.begin(), others.end(), is_guest), others.end());
  }
  if (others.empty()) return;
  throw UsageError(fmt::format(
      "DDS domain {} is busy: {} of an instance that is not yours, or was started by hand; choose "
      "another --domain",
      bus_.domain, text(others)));
}

ChildSpec Launch::spec_of(const std::string& name, bool recorded) const {
  ChildSpec spec;
  spec.name = name;
  spec.log = out_ / "logs" / (spec.name + ".log");
  spec.arguments = {(process_directory() / ("c3rt-" + spec.name)).string(),
                    file_.string(),
                    "--clock=" + std::string(settings_.clock_name()),
                    "--seed=" + std::to_string(settings_.seed),
                    "--domain=" + std::to_string(bus_.domain),
                    "--dds-profile=" + bus_.profile_uri};
  if (bus_.session_id != 0)
    spec.arguments.push_back("--session=" + std::to_string(bus_.session_id));
  for (const std::string& assignment : settings_.overrides)
    spec.arguments.push_back("--set=" + assignment);
  if (spec.name == "plant" && settings_.lockstep) {
    spec.arguments.push_back(std::string("--expect=impedance,planner,vision") +
                             (recorded ? ",recorder" : ""));
  }
  return spec;
}

void Launch::start(Supervisor& supervisor, bool recorded) const {
  for (const char* name : kProcesses) {
    if (!leaves_out(name)) supervisor.start(spec_of(name, recorded));
  }
}

bool LaunchSettings::leaves_out(const std::string& process) const {
  return std::find(without.begin(), without.end(), process) != without.end();
}

int Launch::process_count() const {
  return static_cast<int>(std::count_if(std::begin(kProcesses), std::end(kProcesses),
                                        [this](const char* name) { return !leaves_out(name); }));
}

void Launch::restart(Supervisor& supervisor, const std::string& name) const {
  ChildSpec spec = spec_of(name, false);
  spec.again = true;
  supervisor.start(spec);
}

std::vector<std::string> Launch::serve_words() const {
  std::vector<std::string> words{"serve",
                                 file_.string(),
                                 "--seed=" + std::to_string(settings_.seed),
                                 "--domain=" + std::to_string(bus_.domain),
                                 "--dds=" + settings_.dds_profile,
                                 "--session=" + std::to_string(bus_.session_id),
                                 "--out=" + out_.string()};
  for (const std::string& assignment : settings_.overrides) words.push_back("--set=" + assignment);
  return words;
}

std::string failure_text(const ChildExit& end) {
  std::string text =
      end.name + " " + end.reason + "; the end of its log (" + end.log.string() + "):\n";
  const std::string last = tail(end.log, kTailLines);
  return text + (last.empty() ? "  (empty)\n" : last);
}

}  // namespace c3rt::cli
