#include "cli/soak/soak.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <malloc.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "cli/invariants/load_limits.hpp"
#include "cli/judge.hpp"
#include "cli/log_rotation.hpp"
#include "cli/paths.hpp"
#include "cli/progress.hpp"
#include "cli/recorder.hpp"
#include "cli/soak/proc.hpp"
#include "cli/soak/report.hpp"
#include "cli/soak/watch.hpp"
#include "cli/watch.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/text.hpp"

namespace c3rt::cli::soak {
namespace {

constexpr double kLookAtProcesses = 5.0;  // [s]
constexpr double kLookAtLogs = 1.0;       // [s]
constexpr double kHolds = 1.0;            // between two passes in realtime [s]
constexpr double kLongestRest = 20.0;     // until the planner must hold [s]
constexpr double kSelfAfter = 1.0;        // a pass's begin: the last one's series are gone [s]
constexpr std::size_t kMostAgain = 5;     // commands that show a violation again
constexpr double kWhole = 0.05;           // of the scene's period: the recording's last row [s]
const char* const kSelf = "c3rt";         // this process

class Soak {
 public:
  explicit Soak(const Settings& settings) : settings_(settings), begun_(wall_time()) {
    summary_.seed = settings.launch.seed;
    summary_.clock = settings.launch.clock_name();
    if (settings.launch.in_process) summary_.clock += " in one process";
  }

  int run() {
    if (settings_.launch.lockstep) {
      run_simulated();
    } else {
      run_in_realtime();
    }
    return finish();
  }

 private:
  bool more() const {
    const bool passes = settings_.passes == 0 || summary_.passes < settings_.passes;
    return passes && failed_.empty() && !interrupted_ && !given_up_ &&
           summary_.soaked + kWhole < settings_.duration;
  }

  /// The first time something has been checked and there is a folder.
  void begin(const Launch& launch) {
    if (files_) return;
    summary_.scenario = launch.scenario().name;
    settings_.launch.out = launch.out().string();
    files_.emplace(launch.out());
    fmt::print("c3rt soak {} ({}, seed {}): {}\nresults in {}\n", summary_.scenario, summary_.clock,
               summary_.seed, launch.scenario().description, launch.out().string());
    std::fflush(stdout);
    progress_.emplace("c3rt soak " + summary_.scenario);
  }

  /// Of what was heard up to now, and of what comes.
  void begin_streams(const Launch& launch, const task::Task& task) {
    watch_.begin_streams(invariants::load_limits(launch.scenario(), !settings_.launch.lockstep),
                         task);
  }

  Pass begin_pass(std::uint64_t seed) {
    Pass pass;
    pass.number = ++summary_.passes;
    pass.seed = seed;
    pass.violations = watch_.with([&](Watch& watch) {
      watch.violations.begin_pass(pass.number, seed);
      return watch.violations.count();
    });
    return pass;
  }

  /// @param longest of a pass that comes to its own end [s]
  void end_pass(Pass pass, const Launch& launch, const Recorder& recorder, const task::Task& task,
                double longest) {
    const config::Scenario& scenario = launch.scenario();
    const Live live = recorder.live();
    pass.duration = live.time;
    pass.loops = live.loops;
    pass.whole = live.robot_stopped || live.loops >= scenario.task.loops ||
                 (recorder.done() && live.time + kWhole >= longest);
    if (live.robot_stopped) {
      watch_.with([&](Watch& watch) {
        watch.violations.add("stopped", "robot/state", live.time, kReflexPatience, kReflexPatience,
                             "s");
      });
    }
    if (pass.whole && failed_.empty()) {
      pass.met = judge(recorder.series(), scenario, task, pass);
      ++summary_.whole;
      summary_.met += pass.met ? 1 : 0;
    }
    pass.violations =
        watch_.with([](Watch& watch) { return watch.violations.count(); }) - pass.violations;
    files_->add(pass);
    // what figures or a queue of samples on a busy machine took for a moment, the allocator keeps:
    // given back, what is seen of this process is what it holds
    malloc_trim(0);
  }

  bool judge(const Series& series, const config::Scenario& scenario, const task::Task& task,
             const Pass& pass) {
    const Figures figures = cli::judge(series, scenario, task, pass.seed);
    bool met = true;
    for (const CriterionResult& criterion : figures.criteria) {
      if (criterion.met) continue;
      met = false;
      watch_.with([&](Watch& watch) {
        watch.violations.add("criterion", criterion.name, pass.duration, criterion.value,
                             criterion.limit, "");
      });
    }
    return met;
  }

  void show(double soaked) {
    std::uint64_t violations = 0;
    std::vector<invariants::Violation> news;
    watch_.with([&](Watch& watch) {
      violations = watch.violations.count();
      news = watch.violations.take_news();
    });
    for (const invariants::Violation& violation : news)
      progress_->say("violated: " + describe(violation));
    double share = soaked / settings_.duration;
    if (settings_.passes > 0) {
      share = std::max(
          share, static_cast<double>(summary_.passes - 1) / static_cast<double>(settings_.passes));
    }
    progress_->update(share, fmt::format("pass {}, {:.0f} s soaked, {} violations", summary_.passes,
                                         soaked, violations));
  }

  void look_at(const std::string& name, int pid, const std::filesystem::path& log, double time) {
    const invariants::ProcessSample sample = look_at_process(name, pid, log);
    files_->add(time, sample);
    watch_.with([&](Watch& watch) { watch.processes.hear(time, sample); });
  }

  void look_at_children(const Supervisor& supervisor, const Launch& launch, double time) {
    for (const auto& [name, pid] : supervisor.pids()) {
      children_.insert(name);
      look_at(name, pid, launch.out() / "logs" / (name + ".log"), time);
    }
  }

  void look_for_lost(const Supervisor& supervisor, double time) {
    std::set<std::string> there;
    for (const auto& [name, pid] : supervisor.pids()) there.insert(name);
    watch_.with([&](Watch& watch) {
      for (const std::string& name : children_) {
        invariants::ProcessSample gone;
        gone.name = name;
        if (there.count(name) == 0) watch.processes.hear(time, gone);
      }
    });
  }

  void run_simulated() {
    while (more()) {
      LaunchSettings launch_settings = settings_.launch;
      launch_settings.seed = settings_.launch.seed + summary_.passes;
      {
        Launch launch(launch_settings);
        begin(launch);
        simulate(launch, launch_settings.seed);
      }
      look_at(kSelf, getpid(), {}, summary_.soaked);
    }
  }

  void simulate(Launch& launch, std::uint64_t seed) {
    const config::Scenario& scenario = launch.scenario();
    pass_length_ = scenario.task.duration_s;
    const task::Task task = scenario.task.motion.seeded(seed);
    const Goal goal{task, scenario.task.loops,
                    std::min(pass_length_, settings_.duration - summary_.soaked)};
    if (!settings_.launch.in_process && summary_.passes == 0) launch.require_free_bus();
    begin_streams(launch, task);
    Pass pass = begin_pass(seed);
    Supervisor supervisor;
    Recorder recorder(launch.bus(), goal, nullptr, launch.out(), &watch_);
    if (settings_.launch.in_process) {
      end(watch_in_process(scenario, seed, launch.bus(), recorder, {},
                           [this](const Live& live) { show(summary_.soaked + live.time); }));
    } else {
      launch.start(supervisor, true);
      for (const auto& [name, pid] : supervisor.pids())
        watch_.with([&, process = name](Watch& watch) { watch.processes.restarted(process); });
      watch_processes(supervisor, recorder, launch, [&recorder] { return recorder.done(); });
    }
    recorder.stop();
    supervisor.stop();
    if (!settings_.launch.in_process) launch.lock().set_ended("a pass of a soak ended");
    pass.log_hash = recorder.samples().log_hash();
    end_pass(pass, launch, recorder, task, pass_length_);
    summary_.soaked += recorder.live().time;
  }

  void end(const Ending& ending) {
    interrupted_ = ending.interrupted;
    failed_ = ending.failed;
    details_ = ending.details;
  }

  /// Watches processes that run by themselves. @return false: the soak is over
  bool watch_processes(Supervisor& supervisor, const Recorder& recorder, const Launch& launch,
                       const std::function<bool()>& over) {
    const Ending ending = watch_until(over, supervisor, recorder, [&](const Live& live) {
      const double now = wall_time();
      const double soaked =
          settings_.launch.lockstep ? summary_.soaked + live.time : soaked_until(now, live);
      if (now - looked_at_processes_ > kLookAtProcesses) {
        looked_at_processes_ = now;
        look_at_children(supervisor, launch, soaked);
      }
      if (now - looked_at_logs_ > kLookAtLogs) {
        looked_at_logs_ = now;
        (void)rotate_logs(launch.out() / "logs");  // one that grows on is seen as log_growth
      }
      show(soaked);
    });
    end(ending);
    if (!failed_.empty()) look_for_lost(supervisor, recorder.live().time);
    return !interrupted_ && failed_.empty();
  }

  /// In realtime: since the first scene [s].
  double soaked_until(double now, const Live& live) {
    if (!live_since_ && live.any) live_since_ = now - live.time;
    return live_since_ ? now - *live_since_ : 0.0;
  }

  /// Before anything is made.
  void require_task_that_begins_anew() const {
    const config::Scenario scenario = config::load_scenario(
        scenario_path(settings_.launch.scenario).string(), settings_.launch.overrides);
    if (scenario.task.motion.repeats()) return;
    throw UsageError(fmt::format(
        "the task of {} ({}) ends and cannot begin anew with the same objects: --clock lockstep or "
        "--in-process put them back for each pass",
        scenario.name, scenario.task.motion.kind()));
  }

  void run_in_realtime() {
    require_task_that_begins_anew();
    Launch launch(settings_.launch);
    const config::Scenario& scenario = launch.scenario();
    const task::Task task = scenario.task.motion.seeded(settings_.launch.seed);
    launch.require_free_bus();
    begin(launch);
    pass_length_ = scenario.task.duration_s;
    begin_streams(launch, task);
    const auto goal = [&] {
      return Goal{task, scenario.task.loops,
                  std::min(pass_length_, settings_.duration - summary_.soaked)};
    };
    Supervisor supervisor;
    Pass pass = begin_pass(settings_.launch.seed);
    Recorder recorder(launch.bus(), goal(), nullptr, launch.out(), &watch_);
    launch.start(supervisor, true);
    wire::Bus bus(launch.bus());
    wire::Writer<wire::TaskTarget> targets(bus);
    const auto ask = [&](const char* kind) {
      wire::TaskTarget target{};
      wire::set_text(target.kind, kind);
      targets.write(target, rt::now_ns());
    };
    while (true) {
      bool looked_at_self = false;
      watch_processes(supervisor, recorder, launch, [&] {
        if (!looked_at_self && recorder.live().time > kSelfAfter) {
          looked_at_self = true;
          look_at(kSelf, getpid(), {}, soaked_until(wall_time(), recorder.live()));
        }
        return recorder.done();
      });
      given_up_ = recorder.live().robot_stopped;
      summary_.soaked = soaked_until(wall_time(), recorder.live());
      if (!recorder.done()) recorder.stop();
      watch_.with([](Watch& watch) { watch.samples->end_task(); });
      end_pass(pass, launch, recorder, task, pass_length_);
      if (!more()) break;
      ask("hold");
      if (!watch_processes(supervisor, recorder, launch, rest(recorder))) break;
      ask("scenario");
      summary_.soaked = soaked_until(wall_time(), recorder.live());
      if (!more()) break;
      pass = begin_pass(settings_.launch.seed);
      watch_.with([](Watch& watch) { watch.samples->begin_task(); });
      recorder.begin_again(goal());
      if (!watch_processes(supervisor, recorder, launch, [&recorder] { return !recorder.done(); }))
        break;
    }
    recorder.stop();
    stop(supervisor);
    launch.lock().set_ended("soak ended");
  }

  /// Whether the planner has brought the object to rest and holds, or will not.
  static std::function<bool()> rest(const Recorder& recorder) {
    return [&recorder, asked = wall_time(), holds_since = std::optional<double>()]() mutable {
      const double now = wall_time();
      const std::optional<wire::Plan> plan = recorder.live().plan;
      const bool holds = plan && std::string(plan->phase) == "hold";
      if (!holds) holds_since.reset();
      if (holds && !holds_since) holds_since = now;
      return (holds && now - *holds_since > kHolds) || now - asked > kLongestRest;
    };
  }

  /// Of the first violations, each seed once.
  std::vector<std::string> again() const {
    std::vector<std::string> commands;
    std::set<std::uint64_t> seeds;
    for (const invariants::Violation& violation : watch_.violations.kept()) {
      if (!seeds.insert(violation.seed).second || commands.size() == kMostAgain) continue;
      const LaunchSettings& launch = settings_.launch;
      std::string command = fmt::format("c3rt soak {} --seed {}", launch.scenario, violation.seed);
      if (launch.in_process) command += " --in-process";
      if (launch.lockstep && !launch.in_process) command += " --clock lockstep";
      if (launch.lockstep) command += " --passes 1";
      command += fmt::format(" --duration {:.0f}s",
                             launch.lockstep ? std::ceil(pass_length_) : settings_.duration);
      for (const std::string& assignment : launch.overrides) command += " --set " + assignment;
      commands.push_back(command);
    }
    return commands;
  }

  int finish() {
    progress_.reset();
    summary_.wall = wall_time() - begun_;
    summary_.details = details_;
    summary_.again = again();
    const std::uint64_t violations = watch_.violations.count();
    summary_.samples = watch_.samples_heard();
    summary_.reflexes = watch_.reflexes_seen();
    summary_.result = !failed_.empty() ? failed_
                      : violations > 0 ? "violated"
                      : interrupted_   ? "interrupted"
                                       : "passed";
    const std::filesystem::path out = settings_.launch.out;
    const auto& courses = watch_.processes.courses();
    const std::string text = to_text(summary_, watch_.violations, courses);
    write_text(out / "soak.json", to_json(summary_, watch_.violations, courses).dump(2) + "\n");
    write_text(out / "soak.txt", text);
    std::string missing;
    if (settings_.launch.pictures) {
      missing =
          draw_memory(out, fmt::format("c3rt soak {} ({})", summary_.scenario, summary_.clock),
                      files_->memory());
    }
    say_end(text, missing, out, failed_.empty() ? "" : details_);
    if (!failed_.empty()) return kProcessFailed;
    return violations == 0 && !interrupted_ ? kDone : kCriterionFailed;
  }

  Settings settings_;
  Summary summary_;
  const double begun_;  // by the wall [s]
  Watch watch_;
  std::optional<Files> files_;
  std::optional<Progress> progress_;
  std::set<std::string> children_;                           // that were seen
  double pass_length_ = 0.0;                                 // at most [s]
  double looked_at_processes_ = 0.0, looked_at_logs_ = 0.0;  // by the wall [s]
  std::optional<double> live_since_;
  bool interrupted_ = false, given_up_ = false;
  std::string failed_, details_;
};

}  // namespace

int run(const Settings& settings) { return Soak(settings).run(); }

}  // namespace c3rt::cli::soak
