#include "cli/chaos/chaos.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/chaos/recovery.hpp"
#include "cli/chaos/report.hpp"
#include "cli/chaos/world.hpp"
#include "cli/invariants/load_limits.hpp"
#include "cli/keeper.hpp"
#include "cli/paths.hpp"
#include "cli/progress.hpp"
#include "cli/recorder.hpp"
#include "cli/soak/proc.hpp"
#include "cli/soak/report.hpp"
#include "cli/soak/watch.hpp"
#include "cli/watch.hpp"
#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"

namespace c3rt::cli::chaos {
namespace {

constexpr double kPass = 120.0;           // of simulated time [s]
constexpr double kTail = 5.0;             // after the last fault of a pass [s]
constexpr double kSettled = 1.0;          // after a jump of clocks [s]
constexpr double kLookAtProcesses = 5.0;  // [s]
constexpr double kComesUp = 60.0;         // until the four must run [s]
constexpr double kUnitRestart = 0.2;      // RestartSec of the systemd units [s]
constexpr int kCyclesPerLook = 200;
constexpr int kLoops = std::numeric_limits<int>::max();
constexpr double kForever = std::numeric_limits<double>::infinity();

/// The invariants, and the times of recovery.
class Ears final : public soak::Watch {
 public:
  void hear(const wire::Plan& sample) override { both(sample); }
  void hear(const wire::Scene& sample) override { both(sample); }
  void hear(const wire::RobotState& sample) override { both(sample); }
  void hear(const wire::RobotCommand& sample) override { both(sample); }

  Recovery recovery;

 private:
  template <typename T>
  void both(const T& sample) {
    Watch::hear(sample);
    with([&](Watch&) { recovery.hear(sample); });
  }
};

/// Who keeps the processes running.
class Keepers {
 public:
  Keepers() = default;
  Keepers(const Keepers&) = delete;
  Keepers& operator=(const Keepers&) = delete;
  virtual ~Keepers() = default;
  /// One look. @return what has failed for good
  virtual std::string step() = 0;
  virtual std::vector<std::pair<std::string, pid_t>> pids() const = 0;
  virtual void stop() = 0;
};

/// This process itself, as c3rt serve does it.
class Own final : public Keepers {
 public:
  explicit Own(Launch& launch) : launch_(launch) {
    launch.start(supervisor_, false);
    keeper_.emplace(launch, supervisor_);
  }
  std::string step() override {
    const auto end = keeper_->step();
    return end ? failure_text(*end) : "";
  }
  std::vector<std::pair<std::string, pid_t>> pids() const override { return supervisor_.pids(); }
  void stop() override {
    keeper_.reset();
    cli::stop(supervisor_);
    launch_.lock().set_ended("chaos ended");
  }

 private:
  Launch& launch_;
  Supervisor supervisor_;
  std::optional<Keeper> keeper_;
};

/// c3rt serve, which may be killed itself; this process starts it again, as systemd does.
class Served final : public Keepers {
 public:
  Served(Launch& launch, const Recorder& recorder) : recorder_(recorder) {
    spec_.name = "supervisor";
    spec_.arguments = launch.serve_words();
    spec_.arguments.insert(spec_.arguments.begin(), (binary_directory() / "c3rt").string());
    spec_.log = launch.out() / "logs" / "supervisor.log";
    launch.unlock();
    supervisor_.start(spec_);
    spec_.again = true;
  }
  std::string step() override {
    if (const auto end = supervisor_.take_ended()) {
      if (!WIFSIGNALED(end->status)) return failure_text(*end);
      again_at_ = wall_time() + kUnitRestart;
    }
    if (again_at_ && wall_time() >= *again_at_) {
      again_at_.reset();
      supervisor_.start(spec_);
    }
    return "";
  }
  std::vector<std::pair<std::string, pid_t>> pids() const override {
    std::vector<std::pair<std::string, pid_t>> all = supervisor_.pids();
    for (const auto& status : recorder_.live().services) {
      if (status && status->pid > 0)
        all.emplace_back(wire::process_name(status->process), status->pid);
    }
    return all;
  }
  void stop() override { cli::stop(supervisor_); }

 private:
  const Recorder& recorder_;
  ChildSpec spec_;
  Supervisor supervisor_;
  std::optional<double> again_at_;
};

class Chaos {
 public:
  explicit Chaos(const Settings& settings) : settings_(settings), begun_(wall_time()) {
    summary_.seed = settings.launch.seed;
    summary_.rate = settings.rate;
    summary_.clock = settings.launch.clock_name();
    if (settings.launch.in_process) summary_.clock += " in one process";
    // before there is a folder; what the scenario's cameras allow is looked at with the scenario
    (void)choose(settings.faults, {where(), 1, true});
  }

  int run() {
    if (settings_.launch.in_process) {
      while (more()) {
        LaunchSettings launch_settings = settings_.launch;
        launch_settings.seed = settings_.launch.seed + summary_.passes;
        Launch launch(launch_settings);
        begin(launch);
        simulate(launch, launch_settings.seed);
      }
    } else {
      if (settings_.launch.lockstep)
        throw UsageError("--clock lockstep: simulated faults are of --in-process");
      run_in_realtime();
    }
    return finish();
  }

 private:
  bool more() const {
    return failed_.empty() && !interrupted_ && summary_.lasted + 0.05 < settings_.duration;
  }

  Where where() const { return settings_.launch.in_process ? kSimulated : kRealtime; }

  void begin(const Launch& launch) {
    choices_ = choose(settings_.faults,
                      {where(), extent_of(launch.scenario()).cameras, is_small_disk(launch.out())});
    if (files_) return;
    summary_.scenario = launch.scenario().name;
    settings_.launch.out = launch.out().string();
    files_.emplace(launch.out(), false);  // its passes are no tasks that are met
    fmt::print("c3rt chaos {} ({}, seed {}): {}\nresults in {}\n", summary_.scenario,
               summary_.clock, summary_.seed, launch.scenario().description, launch.out().string());
    std::fflush(stdout);
    progress_.emplace("c3rt chaos " + summary_.scenario);
  }

  /// A run of the streams and its faults.
  void begin_pass(const Launch& launch, const task::Task& task, std::uint64_t seed, double length) {
    invariants::Limits limits =
        invariants::load_limits(launch.scenario(), !settings_.launch.lockstep);
    limits.object_error = kForever;  // what it does meanwhile is what is tried
    ears_.begin_streams(limits, task);
    ears_.with([&](soak::Watch& watch) {
      watch.violations.begin_pass(++summary_.passes, seed);
      ears_.recovery = Recovery();
    });
    schedule_.emplace(choices_, settings_.rate, seed);
    next_ = schedule_->next();
    active_.reset();
    length_ = length;
  }

  void end_pass() {
    ears_.with([&](soak::Watch&) {
      ears_.recovery.finish();
      const auto& outcomes = ears_.recovery.outcomes();
      outcomes_.insert(outcomes_.end(), outcomes.begin(), outcomes.end());
    });
  }

  /// Begins and ends what is due.
  /// @param time since the pass began [s]  @param now_ns the same on the session's clock
  /// @return the fault that has begun, if one has
  const Fault* step(World& world, double time, std::int64_t now_ns) {
    world.look(now_ns);
    if (active_ && time >= active_->end()) {
      world.end(*active_, now_ns);
      ears_.with([&](soak::Watch&) { ears_.recovery.end(now_ns); });
      active_.reset();
    }
    const bool impatient =
        ears_.with([&](soak::Watch&) { return ears_.recovery.lost_patience(now_ns); });
    if (impatient) {
      ears_.with([&](soak::Watch& watch) {
        watch.violations.add("not_recovered", describe(*last_), time, Recovery::kPatience,
                             Recovery::kPatience, "s");
      });
    }
    if (active_ || time < next_.begin || next_.end() + kTail > length_) return nullptr;
    last_ = active_ = next_;
    next_ = schedule_->next();
    ears_.with([&](soak::Watch& watch) {
      ears_.recovery.begin(*active_, now_ns);
      if (active_->kind->act == Act::kShiftClock)
        watch.samples->excuse_time(now_ns + base::nanoseconds(active_->duration + kSettled));
    });
    world.begin(*active_, now_ns);
    return &*last_;
  }

  void show(double lasted) {
    std::uint64_t violations = 0;
    std::size_t faults = 0;
    std::vector<invariants::Violation> news;
    ears_.with([&](soak::Watch& watch) {
      violations = watch.violations.count();
      news = watch.violations.take_news();
      faults = outcomes_.size() + ears_.recovery.outcomes().size();
    });
    for (const invariants::Violation& violation : news)
      progress_->say("violated: " + describe(violation));
    progress_->update(lasted / settings_.duration,
                      fmt::format("{:.0f} s, {} faults, {} violations{}", lasted, faults,
                                  violations, active_ ? ", " + describe(*active_) : ""));
  }

  /// What is tried is the service: this process is written down and not judged.
  void look_at_self(double time) { files_->add(time, soak::look_at_process("c3rt", getpid())); }

  void look_at(const std::string& name, int pid, const std::filesystem::path& log, double time) {
    const invariants::ProcessSample sample = soak::look_at_process(name, pid, log);
    files_->add(time, sample);
    ears_.with([&](soak::Watch& watch) { watch.processes.hear(time, sample); });
  }

  void simulate(Launch& launch, std::uint64_t seed) {
    const config::Scenario& scenario = launch.scenario();
    const task::Task task = scenario.task.motion.seeded(seed);
    const double length = std::min(kPass, settings_.duration - summary_.lasted);
    begin_pass(launch, task, seed, length);
    Recorder recorder(launch.bus(), {task, kLoops, length, kForever}, nullptr, launch.out(),
                      &ears_);
    try {
      InProcess nodes(scenario, seed, launch.bus());
      SimulatedWorld world(scenario, launch.bus(), nodes);
      nodes.join(Recorder::kPeriod_ns,
                 [&recorder](const wire::Sequences& newest) { recorder.take(newest); });
      for (int cycle = 0; !interrupted_ && nodes.now_ns() < base::nanoseconds(length); ++cycle) {
        interrupted_ = wire::StopFlag::requested();
        step(world, base::seconds(nodes.now_ns()), nodes.now_ns());
        nodes.advance();
        if (cycle % kCyclesPerLook == 0) show(summary_.lasted + base::seconds(nodes.now_ns()));
      }
      summary_.lasted += base::seconds(nodes.now_ns());
    } catch (const std::exception& error) {
      failed_ = error.what();
    }
    recorder.stop();
    summary_.log_hashes.push_back(recorder.samples().log_hash());
    end_pass();
    look_at_self(summary_.lasted);
  }

  void run_in_realtime() {
    Launch launch(settings_.launch);
    const task::Task task = launch.scenario().task.motion.seeded(settings_.launch.seed);
    begin(launch);
    launch.require_free_bus();
    begin_pass(launch, task, settings_.launch.seed, settings_.duration);
    // a short recording: after it the listener goes on
    Recorder recorder(launch.bus(), {task, kLoops, 0.1, kForever}, nullptr, launch.out(), &ears_);
    const bool served = std::any_of(choices_.begin(), choices_.end(), [](const Choice& choice) {
      return choice.kind->act == Act::kKillService;
    });
    std::unique_ptr<Keepers> keepers;
    if (served) {
      keepers = std::make_unique<Served>(launch, recorder);
    } else {
      keepers = std::make_unique<Own>(launch);
    }
    {
      RealWorld world(launch, [&keepers] { return keepers->pids(); });
      if (comes_up(*keepers, recorder)) keep(launch, *keepers, world, recorder);
    }
    recorder.stop();
    keepers->stop();
    end_pass();
  }

  bool comes_up(Keepers& keepers, const Recorder& recorder) {
    const double deadline = wall_time() + kComesUp;
    while (failed_.empty() && !interrupted_) {
      interrupted_ = wire::StopFlag::requested();
      if (!look_after(keepers)) return false;
      const Live live = recorder.live();
      const bool all = std::count_if(live.services.begin(), live.services.end(),
                                     [](const auto& s) { return s.has_value(); }) >= 4;
      if (all && recorder.done()) return true;
      if (wall_time() > deadline) failed_ = "the four processes did not come up";
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

  bool look_after(Keepers& keepers) {
    failed_ = keepers.step();
    return failed_.empty();
  }

  void keep(const Launch& launch, Keepers& keepers, World& world, const Recorder& recorder) {
    const std::int64_t begun_ns = rt::now_ns();
    double looked = -kForever;
    while (!interrupted_ && failed_.empty() && summary_.lasted < settings_.duration) {
      interrupted_ = wire::StopFlag::requested();
      const std::int64_t now_ns = rt::now_ns();
      summary_.lasted = base::seconds(now_ns - begun_ns);
      if (const std::string failure = recorder.failure(); !failure.empty())
        failed_ = "recorder: " + failure;
      const Fault* begun = step(world, summary_.lasted, now_ns);
      if (begun != nullptr) note_killed(*begun, looked);
      if (!look_after(keepers)) break;
      if (summary_.lasted - looked > kLookAtProcesses) {
        looked = summary_.lasted;
        for (const auto& [name, pid] : keepers.pids())
          look_at(name, pid, launch.out() / "logs" / (name + ".log"), looked);
        look_at_self(looked);
      }
      show(summary_.lasted);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  /// Who is another one from now on.
  void note_killed(const Fault& fault, double& looked) {
    const Act act = fault.kind->act;
    if (act != Act::kKill && act != Act::kKillService) return;
    std::vector<std::string> names{fault.target};
    if (act == Act::kKillService) {
      for (const auto& each : {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE,
                               c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION})
        names.emplace_back(wire::process_name(each));
    }
    ears_.with([&](soak::Watch& watch) {
      for (const std::string& name : names) {
        watch.processes.restarted(name);
        if (name != "supervisor") watch.samples->restarted(process_of(name));
      }
    });
    looked = summary_.lasted;  // until its successor is there
  }

  /// A command that shows the first violation, or what has not recovered, again.
  std::string again() const {
    const auto& kept = ears_.violations.kept();
    if (kept.empty()) return "";
    const LaunchSettings& launch = settings_.launch;
    std::string command =
        fmt::format("c3rt chaos {} --seed {} --rate {:g} --duration {:.0f}s", launch.scenario,
                    kept.front().seed, settings_.rate,
                    launch.in_process ? std::min(kPass, settings_.duration) : settings_.duration);
    if (launch.in_process) command += " --in-process";
    if (!settings_.faults.empty()) command += " --faults " + settings_.faults;
    for (const std::string& assignment : launch.overrides) command += " --set " + assignment;
    return command;
  }

  int finish() {
    progress_.reset();
    summary_.wall = wall_time() - begun_;
    summary_.samples = ears_.samples_heard();
    summary_.reflexes = ears_.reflexes_seen();
    if (files_) summary_.rows_lost = files_->lost();
    summary_.again = again();
    const std::vector<Criterion> criteria = criteria_of(outcomes_);
    const bool kept = ears_.violations.count() == 0 &&
                      std::all_of(criteria.begin(), criteria.end(),
                                  [](const Criterion& criterion) { return criterion.met; });
    summary_.result = !failed_.empty() ? failed_.substr(0, failed_.find('\n'))
                      : !kept          ? "violated"
                      : interrupted_   ? "interrupted"
                                       : "passed";
    const std::filesystem::path out = settings_.launch.out;
    const std::string text = to_text(summary_, outcomes_, ears_.violations);
    write_text(
        out / "chaos.json",
        to_json(summary_, outcomes_, ears_.violations, ears_.processes.courses()).dump(2) + "\n");
    write_text(out / "chaos.txt", text);
    write_text(out / "faults.csv", to_csv(outcomes_));
    std::string missing;
    if (settings_.launch.pictures) {
      missing = draw_recovery(
          out, fmt::format("c3rt chaos {} ({})", summary_.scenario, summary_.clock), outcomes_);
    }
    soak::say_end(text, missing, out, failed_);
    if (!failed_.empty()) return kProcessFailed;
    return kept && !interrupted_ ? kDone : kCriterionFailed;
  }

  Settings settings_;
  Summary summary_;
  const double begun_;  // by the wall [s]
  Ears ears_;
  std::vector<Choice> choices_;
  std::optional<Schedule> schedule_;
  Fault next_;
  std::optional<Fault> active_, last_;
  double length_ = 0.0;            // of the pass [s]
  std::vector<Outcome> outcomes_;  // of the passes that have ended
  std::optional<soak::Files> files_;
  std::optional<Progress> progress_;
  bool interrupted_ = false;
  std::string failed_;
};

}  // namespace

int run(const Settings& settings) { return Chaos(settings).run(); }

}  // namespace c3rt::cli::chaos
