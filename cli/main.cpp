// The one command that a person types.
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <unistd.h>

#include "cli/bench.hpp"
#include "cli/chaos/chaos.hpp"
#include "cli/chaos/kinds.hpp"
#include "cli/checks.hpp"
#include "cli/client.hpp"
#include "cli/doctor/options.hpp"
#include "cli/evaluation_options.hpp"
#include "cli/examples.hpp"
#include "cli/gap/gap.hpp"
#include "cli/inspect.hpp"
#include "cli/keys/options.hpp"
#include "cli/latency/options.hpp"
#include "cli/launch_options.hpp"
#include "cli/look.hpp"
#include "cli/object_add.hpp"
#include "cli/paths.hpp"
#include "cli/plan.hpp"
#include "cli/record.hpp"
#include "cli/replay/replay.hpp"
#include "cli/ros.hpp"
#include "cli/run.hpp"
#include "cli/scenario.hpp"
#include "cli/service.hpp"
#include "cli/soak/soak.hpp"
#include "cli/solve.hpp"
#include "cli/view.hpp"
#include "controller/task/registry.hpp"
#include "controller/task/request.hpp"
#include "idl/faults.hpp"
#include "idl/process.hpp"

namespace {

using namespace c3rt;

constexpr double kDegree = M_PI / 180.0;  // [rad]

constexpr const char* kExitStatus =
    "Exit status: 0 done and criteria met, 1 ran but a criterion failed or was refused, 2 usage "
    "or\n"
    "configuration error, 3 a process or the machine failed.";

/// The longest that a person may want something to take: a day [s]
constexpr double kLongest = 86400.0;
constexpr double kFastestChaos = 600.0;         // faults in a minute
constexpr double kLongestSoak = 30 * kLongest;  // [s]

void add_seat(CLI::App& command, cli::Seat& seat) {
  command.add_option("--domain", seat.domain, "DDS domain")
      ->check(cli::whole(0, 230))
      ->capture_default_str();
  command
      .add_option("--profile,--dds", seat.dds_profile,
                  "DDS profile, where no instance of yours tells it")
      ->capture_default_str();
}

const std::map<std::string, wire::Process> kProcesses{{"plant", c3rt_v2_PROCESS_PLANT},
                                                      {"impedance", c3rt_v2_PROCESS_IMPEDANCE},
                                                      {"planner", c3rt_v2_PROCESS_PLANNER},
                                                      {"vision", c3rt_v2_PROCESS_VISION}};

std::vector<std::string> process_names() {
  std::vector<std::string> names;
  for (const auto& [name, process] : kProcesses) names.push_back(name);
  return names;
}

const std::vector<std::string> kAxes{"x", "y", "z", "roll", "pitch", "yaw"};

// what no scenario can have; the process that is asked knows its own limits
constexpr double kFarthest = 1e3;  // [m], [N s], [deg]
constexpr int kMostCameras = 64;
constexpr int kMostGoals = 32;
constexpr long long kMostLines = 1'000'000'000;

/// Everything that the command line can hold; chosen() is what it asked for.
class CommandLine {
 public:
  CommandLine() {
    app_.require_subcommand(1);
    app_.footer(cli::examples_text("") + "\n" + kExitStatus);
    app_.set_version_flag("--version", "c3rt " C3RT_VERSION);
    add_running();
    add_machine();
    add_keys();
    add_requests();
    add_faults();
    add_robot();
    add_targets();
    add_weights();
    add_tools();
    add_recordings();
    add_view();
    add_library();
    add_campaign();
    add_tune();
    add_gap();
    add_reproduce();
  }

  int run(int argc, char** argv) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::Success& help) {
      return app_.exit(help);
    } catch (const CLI::ParseError& error) {
      fmt::print(stderr, "c3rt: error: {}\n", cli::complaint(app_, error));
      return cli::kUsage;
    }
    return action_();
  }

 private:
  /// A command with its own examples.
  CLI::App* group(CLI::App& parent, const std::string& name, const std::string& description) {
    const std::string path = &parent == &app_ ? name : parent.get_name() + " " + name;
    CLI::App* added = parent.add_subcommand(name, description);
    added->footer(cli::examples_text(path));
    return added;
  }

  CLI::App* command(CLI::App& parent, const std::string& name, const std::string& description,
                    std::function<int()> action) {
    CLI::App* added = group(parent, name, description);
    added->callback([this, action = std::move(action)] { action_ = action; });
    return added;
  }

  void add_running() {
    CLI::App* run = command(
        app_, "run", "One run from start to report: exits with the criteria's verdict", [this] {
          if (const auto example = launch_.read_example())
            return cli::run_example(*example, &wire::StopFlag::requested);
          return cli::run(launch_.read("run"));
        });
    launch_.add_to(*run);
    launch_.add_results_to(*run);
    launch_.add_without_to(*run);
    launch_.add_deciding_to(*run);
    add_soak();
    add_chaos();
    CLI::App* up =
        command(app_, "up", "Starts the four processes as a service and returns", [this] {
          const cli::LaunchSettings settings = up_.read("up");
          return cli::up(settings, up_.words());
        });
    up_.add_to(*up);
    up_.add_without_to(*up);
    CLI::App* serve = command(app_, "serve", "The supervisor behind c3rt up, in the foreground",
                              [this] { return cli::serve(serve_.read("up")); });
    serve_.add_to(*serve);
    // of c3rt chaos, which listens on while the supervisor is another one
    serve->add_option("--session", serve_.settings.session)->group("");
    serve_.add_without_to(*serve);
    add_seat(*command(app_, "down", "Ends the instance on this domain",
                      [this] { return cli::down(seat_); }),
             seat_);
    add_seat(
        *command(app_, "status", "What runs, and how it is", [this] { return cli::status(seat_); }),
        seat_);
  }

  void add_machine() {
    cli::doctor::add_options(*command(app_, "doctor", "What is missing, and what to do about it",
                                      [this] { return cli::doctor::run(doctor_); }),
                             doctor_);
    cli::latency::add_options(
        *command(app_, "latency",
                 "What this machine can hold: wake-up, DDS, servo, image to torque",
                 [this] { return cli::latency::run(latency_); }),
        latency_);
  }

  void add_keys() {
    CLI::App& parent = *group(app_, "keys", "Keys of a secure bus, for --profile secure");
    parent.require_subcommand(1);
    cli::keys::add_init_options(
        *command(parent, "init", "Makes an authority, and keys and rights for each process",
                 [this] { return cli::keys::init(keys_); }),
        keys_);
    cli::keys::add_check_options(
        *command(parent, "check", "Says whether they are good, until when, and what is wrong",
                 [this] { return cli::keys::check(keys_); }),
        keys_);
  }

  void add_soak() {
    CLI::App* soak =
        command(app_, "soak", "The task again and again, with invariants looked at on every sample",
                [this] {
                  soak_.launch = soaked_.read("soak");
                  return cli::soak::run(soak_);
                });
    soaked_.add_scenario_to(*soak);
    soaked_.add_in_process_to(*soak);
    soak->add_option("--duration", soak_.duration,
                     "In all, of simulated time or in realtime of the wall's: 10s, 90m, 24h")
        ->transform(cli::duration(1.0, kLongestSoak))
        ->default_str("10m");
    soak->add_option("--passes", soak_.passes, "Ends after so many, if the time is not over before")
        ->check(cli::whole(1, kMostLines));
  }

  void add_chaos() {
    CLI::App* chaos = command(
        app_, "chaos", "Faults drawn from a seed, and how long the task takes to go on after each",
        [this] {
          chaos_.launch = shaken_.read("chaos");
          return cli::chaos::run(chaos_);
        });
    chaos->footer(cli::chaos::kinds_text() + "\n" + cli::examples_text("chaos"));
    shaken_.add_scenario_to(*chaos);
    shaken_.add_in_process_to(*chaos);
    chaos->add_option("--faults", chaos_.faults,
                      "Kinds, with a comma between them; default: all below that can be done");
    chaos
        ->add_option("--rate", chaos_.rate,
                     "Faults in a minute of the time from one's end to the next one's begin")
        ->check(cli::number(0.01, kFastestChaos))
        ->capture_default_str();
    chaos
        ->add_option("--duration", chaos_.duration,
                     "In all, of simulated time or in realtime of the wall's: 10s, 90m, 24h")
        ->transform(cli::duration(1.0, kLongestSoak))
        ->default_str("10m");
  }

  void add_requests() {
    // the plant holds the robot's own errors, the others their part of standing still
    const auto add = [this](const char* name, const char* description, c3rt_v2_RequestVerb verb) {
      CLI::App* added = command(app_, name, description, [this, verb] {
        return cli::request(
            seat_, {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER},
            verb);
      });
      add_seat(*added, seat_);
    };
    add("recover", "Ends a reflex or a stop: the arm moves again", c3rt_v2_REQUEST_RECOVER);
    add("stop", "Stops the robot until recover", c3rt_v2_REQUEST_STOP);
  }

  CLI::App* fault(CLI::App& parent, const std::string& name, const std::string& description,
                  c3rt_v2_FaultKind kind, std::optional<wire::Process> process) {
    CLI::App* added = command(parent, name, description, [this, kind, process] {
      wire::FaultInject sample{};
      sample.kind = kind;
      sample.process = process ? *process : kProcesses.at(process_);
      sample.index = index_;
      sample.duration_s = fault_duration_s_;
      for (std::size_t i = 0; i < 3; ++i) sample.value[i] = impulse_ns_[i];
      return cli::inject(seat_, sample);
    });
    add_seat(*added, seat_);
    if (!process)
      added->add_option("process", process_, "Which process")
          ->required()
          ->check(cli::one_of(process_names()));
    const bool lasts = kind != c3rt_v2_FAULT_NONE && kind != c3rt_v2_FAULT_PUSH_OBJECT;
    if (lasts)
      added->add_option("--for", fault_duration_s_, "How long [s]")
          ->check(cli::number(0.001, wire::kLongestFault))
          ->capture_default_str();
    return added;
  }

  void add_faults() {
    CLI::App& parent = *group(app_, "fault", "Makes something go wrong");
    parent.require_subcommand(1);
    CLI::App* push = fault(parent, "push-object", "Pushes an object", c3rt_v2_FAULT_PUSH_OBJECT,
                           c3rt_v2_PROCESS_PLANT);
    push->alias("push-ball");  // of versions before 0.7
    push->add_option("--impulse", impulse_ns_, "Along x, y, z [N s]")
        ->expected(3)
        ->required()
        ->check(cli::number(-kFarthest, kFarthest));
    push->add_option("--object,--ball", index_, "Which object")
        ->check(cli::whole(0, c3rt_v2_MAX_OBJECTS - 1));
    fault(parent, "drop-commands", "The plant ignores commands", c3rt_v2_FAULT_DROP_COMMANDS,
          c3rt_v2_PROCESS_PLANT);
    fault(parent, "freeze-camera", "A camera sees nothing", c3rt_v2_FAULT_FREEZE_CAMERA,
          c3rt_v2_PROCESS_VISION)
        ->add_option("--camera", index_, "Which camera")
        ->check(cli::whole(0, kMostCameras - 1));
    fault(parent, "lose-object", "No camera sees the objects", c3rt_v2_FAULT_LOSE_OBJECT,
          c3rt_v2_PROCESS_VISION)
        ->alias("lose-ball");
    fault(parent, "stall", "A process stops answering", c3rt_v2_FAULT_STALL, std::nullopt);
    fault(parent, "nan", "A process writes NaN", c3rt_v2_FAULT_NAN, std::nullopt);
    fault(parent, "none", "Ends every fault of a process", c3rt_v2_FAULT_NONE, std::nullopt);
  }

  /// What a person does to the robot itself. @param fill the order, once the words are read
  CLI::App* order(CLI::App& parent, const std::string& name, const std::string& description,
                  std::function<void(wire::RobotOrder&)> fill) {
    CLI::App* added = command(parent, name, description, [this, fill = std::move(fill)] {
      wire::RobotOrder sample{};
      fill(sample);
      return cli::order(seat_, sample);
    });
    add_seat(*added, seat_);
    return added;
  }

  void add_robot() {
    CLI::App& parent =
        *group(app_, "robot", "What a person does to the robot itself, by hand or by a setting");
    parent.require_subcommand(1);
    add_thresholds(parent);
    CLI::App* guide = order(parent, "guide", "Takes the arm by the hand, while nothing moves it",
                            [this](wire::RobotOrder& sample) {
                              sample.kind = c3rt_v2_ORDER_GUIDING;
                              sample.engaged = true;
                              for (const std::string& axis : axes_) {
                                const auto place = std::find(kAxes.begin(), kAxes.end(), axis);
                                sample.free_axes |= 1U << (place - kAxes.begin());
                              }
                              sample.free_elbow = !elbow_locked_;
                            });
    guide
        ->add_option("--axes", axes_,
                     "Of the world, along and about which it can be led: x,y,yaw; default: all")
        ->delimiter(',')
        ->check(cli::one_of(kAxes));
    guide->add_flag("--lock-elbow", elbow_locked_, "Joint 3 stays where it is");
    order(parent, "release", "Lets go of the arm",
          [](wire::RobotOrder& sample) { sample.kind = c3rt_v2_ORDER_GUIDING; });
    CLI::App* stop = order(parent, "user-stop", "Presses the robot's stop button, or releases it",
                           [this](wire::RobotOrder& sample) {
                             sample.kind = c3rt_v2_ORDER_USER_STOP;
                             sample.engaged = button_ == "press";
                           });
    stop->add_option("button", button_, "press or release")
        ->required()
        ->check(cli::one_of({"press", "release"}));
    CLI::App* push =
        order(parent, "push", "Pushes the end effector", [this](wire::RobotOrder& sample) {
          sample.kind = c3rt_v2_ORDER_PUSH;
          std::copy(force_n_.begin(), force_n_.end(), sample.force_W_n);
          sample.duration_s = push_s_;
        });
    numbers(*push, "--force", force_n_, "Along x, y, z of the world [N]")->expected(3)->required();
    push->add_option("--for", push_s_, "How long [s]")
        ->check(cli::number(0.001, 60.0))
        ->capture_default_str();
  }

  void add_thresholds(CLI::App& parent) {
    CLI::App* thresholds = order(
        parent, "thresholds",
        "From which force on a contact is told and a collision stops the robot; while nothing "
        "moves it",
        [this](wire::RobotOrder& sample) {
          sample.kind = c3rt_v2_ORDER_THRESHOLDS;
          // a contact that has no threshold is told with the collision
          if (contact_torque_nm_.empty()) contact_torque_nm_ = collision_torque_nm_;
          if (contact_force_n_.empty()) contact_force_n_ = collision_force_n_;
          c3rt_v2_ContactThresholds& to = sample.nominal;
          spread("--collision-torque", collision_torque_nm_, 7, to.collision_torque_nm);
          spread("--contact-torque", contact_torque_nm_, 7, to.contact_torque_nm);
          spread("--collision-force", collision_force_n_, 6, to.collision_force_E_n);
          spread("--collision-force", collision_force_n_, 6, to.collision_torque_E_nm, 3);
          spread("--contact-force", contact_force_n_, 6, to.contact_force_E_n);
          spread("--contact-force", contact_force_n_, 6, to.contact_torque_E_nm, 3);
          sample.acceleration = sample.nominal;
        });
    const auto add = [&](const char* name, std::vector<double>& values, const char* what) {
      return thresholds->add_option(name, values, what)->check(cli::number(0.0, kFarthest));
    };
    add("--collision-torque", collision_torque_nm_, "Of each joint, or one for all seven [N m]")
        ->required()
        ->expected(1, 7);
    add("--collision-force", collision_force_n_,
        "Along and about x, y, z of the end effector, or one for all six [N, N m]")
        ->required()
        ->expected(1, 6);
    add("--contact-torque", contact_torque_nm_, "The same of a contact; default: as of a collision")
        ->expected(1, 7);
    add("--contact-force", contact_force_n_, "The same of a contact; default: as of a collision")
        ->expected(1, 6);
  }

  /// As many as the field has, from the place `first` on, of one number or of `count`.
  template <std::size_t n>
  static void spread(const char* name, const std::vector<double>& values, std::size_t count,
                     double (&out)[n], std::size_t first = 0) {
    if (values.size() != 1 && values.size() != count) {
      throw cli::UsageError(fmt::format("robot thresholds: {}: expected 1 or {} numbers, got {}",
                                        name, count, values.size()));
    }
    for (std::size_t i = 0; i < n; ++i) out[i] = values.size() == 1 ? values[0] : values[first + i];
  }

  /// @param wanted its parameters, by the keys of a scenario's section `task`
  CLI::App* target(CLI::App& parent, const std::string& kind, const std::string& description,
                   std::function<std::vector<task::Parameter>()> wanted) {
    CLI::App* added = command(parent, kind, description, [this, kind, wanted = std::move(wanted)] {
      return cli::set_target(seat_, {kind, wanted()});
    });
    add_seat(*added, seat_);
    return added;
  }

  /// An option of numbers.
  static CLI::Option* numbers(CLI::App& command, const std::string& name,
                              std::vector<double>& values, const std::string& description) {
    return command.add_option(name, values, description)
        ->check(cli::number(-kFarthest, kFarthest))
        ->capture_default_str();
  }
  static CLI::Option* number(CLI::App& command, const std::string& name, double& value,
                             const std::string& description) {
    return command.add_option(name, value, description)
        ->check(cli::number(-kFarthest, kFarthest))
        ->capture_default_str();
  }
  static std::vector<double> radians(std::vector<double> degrees) {
    for (double& angle : degrees) angle *= kDegree;
    return degrees;
  }

  void add_targets() {
    CLI::App& parent = *group(app_, "target", "Gives the planner another task");
    parent.require_subcommand(1);
    add_circle(parent);
    add_path(parent);
    add_line(parent);
    add_pose(parent);
    add_any_task(parent);
    target(parent, "hold", "Brings the object to rest and leaves it",
           [] { return std::vector<task::Parameter>{}; });
    target(parent, "scenario", "Back to the scenario's own task",
           [] { return std::vector<task::Parameter>{}; });
  }

  void add_circle(CLI::App& parent) {
    CLI::App* circle = target(parent, "circle", "A circle on the table", [this] {
      return std::vector<task::Parameter>{{"center_m", position_m_, ""},
                                          {"radius_m", {radius_m_}, ""},
                                          {"lead_rad", {lead_deg_ * kDegree}, ""}};
    });
    numbers(*circle, "--center", position_m_, "x and y [m]")->expected(2);
    circle->add_option("--radius", radius_m_, "[m]")
        ->check(cli::number(0.0, kFarthest))
        ->capture_default_str();
    number(*circle, "--lead-deg", lead_deg_,
           "How far ahead the target runs; positive is clockwise from above");
  }

  void add_path(CLI::App& parent) {
    CLI::App* path = target(parent, "path", "Along way-points in time, over and over", [this] {
      return std::vector<task::Parameter>{{"points_m", points_m_, ""},
                                          {"interval_s", {interval_s_}, ""},
                                          {"between", {}, held_ ? "hold" : "interpolate"},
                                          {"lead_s", {lead_s_}, ""},
                                          {"preview", {held_ ? 0.0 : 1.0}, ""}};
    });
    numbers(*path, "points", points_m_, "x and y of each way-point [m]")->required();
    number(*path, "--interval", interval_s_, "From one to the next [s]");
    number(*path, "--lead", lead_s_, "Aims at where the object should be so much later [s]");
    path->add_flag("--held", held_, "Jumps from one to the next instead of moving between them");
  }

  void add_line(CLI::App& parent) {
    CLI::App* line = target(parent, "line", "All objects along a line of constant x", [this] {
      return std::vector<task::Parameter>{{"x_m", {x_m_}, ""},
                                          {"step_m", {step_m_}, ""},
                                          {"y_end_m", {y_end_m_}, ""},
                                          {"spacing_m", {spacing_m_}, ""}};
    });
    number(*line, "--x", x_m_, "Of the line [m]");
    number(*line, "--step", step_m_, "Of y at a time; its sign is the direction [m]");
    number(*line, "--end", y_end_m_, "y where an object has arrived [m]");
    number(*line, "--spacing", spacing_m_, "Of the places past the end [m]");
  }

  void add_pose(CLI::App& parent) {
    CLI::App* pose =
        target(parent, "pose", "An object is brought there, or from goal to goal", [this] {
          std::vector<task::Parameter> given{{"goals_m", points_m_, ""},
                                             {"position_tolerance_m", {tolerance_m_}, ""},
                                             {"hold_s", {hold_s_}, ""},
                                             {"object", {static_cast<double>(index_)}, ""}};
          if (!yaws_deg_.empty()) {
            given.push_back({"yaws_rad", radians(yaws_deg_), ""});
            given.push_back({"angle_tolerance_rad", {angle_deg_ * kDegree}, ""});
          }
          return given;
        });
    numbers(*pose, "goals", points_m_, "x and y of each goal [m]")->required();
    numbers(*pose, "--yaw-deg", yaws_deg_, "Its angle about z, of all goals or of each")
        ->expected(1, kMostGoals);
    number(*pose, "--tolerance", tolerance_m_, "Distance at which it is there [m]");
    number(*pose, "--angle-tolerance-deg", angle_deg_, "And angle, where --yaw-deg is given");
    number(*pose, "--hold", hold_s_, "It has to stay there for so long [s]");
    pose->add_option("--object", index_, "Which object")
        ->check(cli::whole(0, c3rt_v2_MAX_OBJECTS - 1))
        ->capture_default_str();
  }

  /// Of every kind that the registry has, those above in other words.
  void add_any_task(CLI::App& parent) {
    CLI::App* any =
        command(parent, "task", "A task of any kind, by the words of a scenario", [this] {
          std::vector<task::Parameter> given;
          try {
            for (const std::string& text : parameters_)
              given.push_back(task::parse_parameter(text));
          } catch (const task::RequestError& error) {
            throw cli::UsageError(std::string("target: ") + error.what());
          }
          return cli::set_target(seat_, {kind_, given});
        });
    any->add_option("kind", kind_, "What the objects are to do")
        ->required()
        ->check(cli::one_of(task::kinds()));
    any->add_option("parameters", parameters_, "KEY=VALUE of each parameter, as in section task");
    add_seat(*any, seat_);
  }

  void add_weights() {
    CLI::App& parent = *group(app_, "weights", "Other weights of Algorithm 1, while it runs");
    parent.require_subcommand(1);
    CLI::App* list = command(parent, "list", "Those that may be changed, and how far",
                             [this] { return cli::list_weights(seat_); });
    CLI::App* set = command(parent, "set", "Gives the planner some others", [this] {
      std::map<std::string, double> weights;
      for (const std::string& text : parameters_) {
        const auto [name, value] = weight(text);
        weights[name] = value;
      }
      return cli::set_weights(seat_, weights);
    });
    set->add_option("weights", parameters_, "NAME=VALUE of each, by the names of c3rt weights list")
        ->required();
    CLI::App* own = command(parent, "scenario", "Back to the scenario's own",
                            [this] { return cli::set_weights(seat_, {}); });
    for (CLI::App* added : {list, set, own}) add_seat(*added, seat_);
  }
  static std::pair<std::string, double> weight(const std::string& text) {
    try {
      const task::Parameter read = task::parse_parameter(text);
      if (read.values.size() == 1 && read.word.empty()) return {read.name, read.values.front()};
    } catch (const task::RequestError&) {
      // told below
    }
    throw cli::UsageError("weights: expected NAME=VALUE with a number, got \"" + text + "\"");
  }

  void add_tools() {
    CLI::App* topics =
        command(app_, "topics", "Every topic: readers, writers, rate, type, QoS; and problems",
                [this] { return cli::print_topics(seat_, peers_); });
    add_seat(*topics, seat_);
    topics->add_flag("--peers", peers_, "Also every reader and writer, with its process and QoS");
    CLI::App* echo = command(app_, "echo", "Samples of a topic as JSON, one a line",
                             [this] { return cli::echo(seat_, look_); });
    CLI::App* hz = command(app_, "hz", "Rate, jitter and losses of a topic, by key and writer",
                           [this] { return cli::measure_rate(seat_, look_); });
    for (CLI::App* tool : {echo, hz}) {
      add_seat(*tool, seat_);
      tool->add_option("topic", look_.topic, "Name of a topic: c3rt topics lists them")->required();
      tool->add_option("--count,-n", look_.count,
                       "Samples (hz: seconds) to print; 0: until interrupted")
          ->check(cli::whole(0, kMostLines));
      tool->add_option("--timeout", look_.timeout_s,
                       "Ends with status 1 after so long without a sample [s]; 0: waits on")
          ->check(cli::number(0.0, kLongest))
          ->capture_default_str();
    }
  }

  static void add_shown(CLI::App& program, cli::ShownScenario& shown) {
    program.add_option("--scenario", shown.scenario,
                       "Whose objects are shown; default: that of the instance");
    cli::add_overrides(program, shown.overrides, "it");
  }

  void add_view() {
    CLI::App* page = command(app_, "view", "What happens, live in a browser",
                             [this] { return cli::view(seat_, view_); });
    add_shown(*page, view_.shown);
    page->add_option("--port", view_.port, "Of the page")
        ->check(cli::whole(1, 65535))
        ->capture_default_str();
    page->add_option("--host", view_.host, "That it is served to; 0.0.0.0: the whole network")
        ->capture_default_str();
    add_seat(*page, seat_);
    CLI::App* border =
        command(app_, "ros", "The border to ROS 2: joint states, tf, poses, markers; goals",
                [this] { return cli::ros(seat_, ros_); });
    add_shown(*border, ros_.shown);
    border->add_option("--ros-domain", ros_.domain, "ROS 2's; default: ROS_DOMAIN_ID, else 0")
        ->check(cli::whole(0, 230));
    border->add_option("--frame", ros_.frame, "ROS 2's name of the robot's base frame")
        ->capture_default_str();
    border->add_option("--rate", ros_.rate_hz, "Of joint states and tf [Hz]")
        ->check(cli::number(1.0, 1000.0))
        ->capture_default_str();
    add_seat(*border, seat_);
  }

  void add_recordings() {
    CLI::App* record = command(app_, "record", "Every sample of a running instance into one file",
                               [this] { return cli::record(seat_, record_); });
    record->add_option("file", record_.file, "A new file, by custom FILE.mcap")->required();
    record
        ->add_option("--duration", record_.duration_s,
                     "Ends after this long [s]; 0: when interrupted")
        ->check(cli::number(0.0, kLongest))
        ->capture_default_str();
    record
        ->add_option("--timeout", record_.timeout_s,
                     "Ends after so long without a sample [s]; 0: waits on")
        ->check(cli::number(0.0, kLongest))
        ->capture_default_str();
    add_seat(*record, seat_);

    CLI::App* report = command(app_, "report", "The report of a recording, as its run gave it",
                               [this] { return cli::report_recording(report_); });
    report->add_option("file", report_.file, "run.mcap of a run, or what c3rt record wrote")
        ->required();
    report->add_option("--scenario", report_.scenario,
                       "By which it is judged; default: that which the recording tells");
    cli::add_overrides(*report, report_.overrides, "it");
    report
        ->add_option("--seed", report_.seed, "Of the run; default: that which the recording tells")
        ->check(cli::whole(0, std::numeric_limits<long long>::max()));
    report->add_option("--out", report_.out,
                       "Folder for report.json and the pictures; default: none");
    report->add_option("--series", report_.series,
                       "Folder for what the figures are made of: objects.csv, end_effector.csv, "
                       "path.csv; default: none");

    add_replay();
    CLI::App* tables =
        command(app_, "export", "The samples of a recording as one CSV file a topic",
                [this] { return cli::export_recording(recording_, topics_, export_to_); });
    tables->add_option("file", recording_, "run.mcap of a run, or what c3rt record wrote")
        ->required();
    tables->add_option("--topics", topics_, "Of these alone: robot/state,plan")->delimiter(',');
    tables->add_option("--out", export_to_, "Folder; default: FILE_csv beside the file");
  }

  void add_replay() {
    CLI::App* replay = command(
        app_, "replay", "A recording for live processes, or beside the answers of a fresh one",
        [this] { return cli::replay::run(seat_, replay_); });
    replay->add_option("file", replay_.file, "run.mcap of a run, or what c3rt record wrote")
        ->required();
    CLI::Option* topics =
        replay
            ->add_option("--topics", replay_.topics,
                         "Of these alone: robot/state,plan; default: all that nobody else writes, "
                         "but requests and faults")
            ->delimiter(',');
    CLI::Option* rate =
        replay->add_option("--rate", replay_.rate, "2: twice as fast; max or 0: as fast as it goes")
            ->transform(cli::number_or(0.01, 1000.0, "max", 0.0))
            ->capture_default_str();
    CLI::Option* compare =
        replay
            ->add_option("--compare", replay_.compare,
                         "Gives a fresh planner, vision or impedance its recorded input, in this "
                         "process, and compares the answers")
            ->check(cli::one_of({"planner", "vision", "impedance"}))
            ->excludes(topics)
            ->excludes(rate);
    add_seat(*replay, seat_);
    for (const char* of_a_bus : {"--domain", "--profile"})
      compare->excludes(replay->get_option(of_a_bus));
    replay
        ->add_option("--scenario", replay_.scenario,
                     "Of the fresh one; default: that which the recording tells")
        ->needs(compare);
    cli::add_overrides(*replay, replay_.overrides, "it")->needs(compare);
    replay->add_option("--seed", replay_.seed, "Of the fresh one; default: that of the recording")
        ->check(cli::whole(0, std::numeric_limits<long long>::max()))
        ->needs(compare);
  }

  void add_campaign() {
    cli::add_options(*command(app_, "campaign", "Many seeds of one scenario in lockstep, one table",
                              [this]() -> int { cli::campaign(campaign_); }),
                     campaign_);
  }

  void add_tune() {
    cli::add_options(
        *command(app_, "tune", "Finds numbers of a scenario by CMA-ES, judged on other seeds",
                 [this]() -> int { cli::tune(tune_); }),
        tune_);
  }

  void add_gap() {
    CLI::App* gap =
        command(app_, "gap", "How far C3's plans are from the optimum of the whole problem",
                [this] { return cli::gap::run(gap_, &wire::StopFlag::requested); });
    gap->add_option(
           "what", gap_.what,
           "A problem file (.json); a numerical example's name or file, whose trial is run; or "
           "a recording (run.mcap) of one ball")
        ->required();
    gap->add_option("--states", gap_.states,
                    "Control steps of the example's trial, or plans of the recording")
        ->check(cli::whole(1, 100000))
        ->capture_default_str();
    cli::add_overrides(*gap, gap_.overrides, "the example or of the recording's scenario");
    gap->add_option("--planner", gap_.planners,
                    "A scenario whose planner answers for the same states, too, of the example's "
                    "kind or for the recording's ball; several by saying it again")
        ->expected(1)
        ->take_all();
    gap->add_option("--polish", gap_.polish,
                    "QPs that polish each plan, in place of what scenario or problem say")
        ->check(cli::whole(0, 10000));
    gap->add_option("--seed", gap_.seed, "Of the trial")
        ->check(cli::whole(0, std::numeric_limits<long long>::max()))
        ->capture_default_str();
    gap->add_option("--limit", gap_.limit_s, "Time of each exact search [s]")
        ->check(cli::number(0.001, kLongest))
        ->capture_default_str();
    gap->add_option("--relative-gap", gap_.relative_gap,
                    "Between a plan and a proven bound that counts as the optimum")
        ->check(cli::number(1e-7, 1.0))
        ->capture_default_str();
    gap->add_flag(
        "--first-input", gap_.first_input,
        "Also how far above the best is that a plan's first input leaves: one more search "
        "of each plan");
    gap->add_option("--out", gap_.out, "Folder of results; default: out/gap-NAME");
  }

  void add_reproduce() {
    cli::add_options(
        *command(app_, "reproduce", "Tables and figures of the paper, our numbers beside its own",
                 [this]() -> int { cli::reproduce(reproduce_); }),
        reproduce_);
  }

  void add_library() {
    CLI::App* solve =
        command(app_, "solve", "One call of C3 on a problem file (schema c3-problem-1)",
                [this] { return cli::solve(problem_, out_); });
    solve->add_option("problem", problem_, "Problem file (JSON): docs/problem_files.md")
        ->required();
    solve->add_option("--out", out_, "Result file; default: standard output");
    CLI::App* scenario = command(
        app_, "scenario", "Prints a scenario whole, with the file and line of every value", [this] {
          if (as_keys_) return cli::print_keys(scenario_, overrides_);
          if (as_json_) return cli::print_scenario_json(scenario_, overrides_);
          return scenario_.empty() ? cli::list_scenarios()
                                   : cli::print_scenario(scenario_, overrides_);
        });
    scenario->add_flag("--keys", as_keys_,
                       "Prints instead which keys are read: what is expected, and what stands in "
                       "the place of one that is left out");
    scenario->add_option("scenario", scenario_,
                         "Name of a scenario, or a path to its file; none: lists those there are");
    cli::add_overrides(*scenario, overrides_);
    scenario
        ->add_flag("--json", as_json_,
                   "Prints it as JSON, for programs: its file, texts, values and the files "
                   "that they name")
        ->needs(scenario->get_option("scenario"));
    CLI::App* plan =
        command(app_, "plan",
                "The planner for a simulator of your own: a scene a line in, a plan a line out",
                [this] { return cli::plan(scenario_, overrides_, std::cin, std::cout); });
    plan->add_option("scenario", scenario_, "Name of a scenario, or a path to its file")
        ->required();
    cli::add_overrides(*plan, overrides_);
    add_lcs();
    add_object();
    add_bench();
  }

  void add_lcs() {
    CLI::App& parent = *group(app_, "lcs", "The linear complementarity system of a model");
    parent.require_subcommand(1);
    CLI::App* inspect = command(
        parent, "inspect", "Bodies, contacts, sizes, conditioning and errors of a MuJoCo model",
        [this] { return cli::inspect(inspect_); });
    inspect
        ->add_option("models", inspect_.models,
                     "MJCF files of 1 to 4 objects, one each, or one of a mechanism with motors "
                     "and objects: docs/objects.md")
        ->required()
        ->expected(1, 4);
    inspect
        ->add_option("--pairs", inspect_.pairs,
                     "Contacts that the LCS has; default: all there are. Of a model with motors "
                     "FIRST,SECOND[,closest=N][,friction=MU] by bodies or geoms")
        ->expected(1, 64)
        ->check(cli::one_of_or_list(cli::inspect_pairs()));
    inspect->add_option("--contact-model", inspect_.contact_model, "anitescu or stewart_trinkle")
        ->check(cli::one_of({"anitescu", "stewart_trinkle"}))
        ->capture_default_str();
    inspect->add_option("--step", inspect_.step, "Of the LCS [s]")
        ->check(cli::number(1e-4, 1.0))
        ->capture_default_str();
    inspect
        ->add_option("--effector", inspect_.effector,
                     "Where the end effector is: x y z from the first object's centre of mass [m]; "
                     "default: 10 mm behind it")
        ->expected(3)
        ->check(cli::number(-10.0, 10.0));
    inspect->add_option("--support-points", inspect_.support_points, "Of each object: 3 or 4")
        ->check(cli::whole(3, 4))
        ->capture_default_str();
    inspect
        ->add_option("--directions", inspect_.directions,
                     "Of friction at each contact of a model with motors: 0 to 8; default: 2")
        ->check(cli::whole(0, 8));
    inspect
        ->add_option("--across", inspect_.across,
                     "x y z: the first direction of friction is across this, of a mechanism "
                     "in a plane its normal")
        ->expected(3)
        ->check(cli::number(-1.0, 1.0));
    inspect->add_option("--out", inspect_.out, "File of the LCS as a problem of c3rt solve");
  }

  void add_object() {
    CLI::App& parent = *group(app_, "object", "Objects of your own");
    parent.require_subcommand(1);
    CLI::App* add = command(parent, "add", "From a mesh to a MuJoCo model that plans and runs take",
                            [this] { return cli::add_object(object_); });
    add->add_option("file", object_.file, "Mesh: .obj, or .stl (binary or ASCII)")->required();
    add->add_option("--mass", object_.mass, "Of the object [kg]")
        ->required()
        ->check(cli::number(1e-3, 100.0));
    add->add_option("--name", object_.name, "Of the object and its files; default: the file's");
    add->add_option("--friction", object_.friction, "Coefficient of its surface")
        ->check(cli::number(0.0, 10.0))
        ->capture_default_str();
    add->add_option("--scale", object_.scale, "From the file's unit to metres: 0.001 of mm")
        ->check(cli::number(1e-6, 1e6))
        ->capture_default_str();
    add->add_option("--out", object_.out, "Folder of the model and its meshes")
        ->capture_default_str();
    add->add_flag("--decompose", object_.decompose,
                  "Divides what is hollow into convex pieces by CoACD, if it is installed");
    add->add_option("--tags", object_.first_tag,
                    "Puts AprilTags (tag36h11) on its top, of this id and those after it")
        ->check(cli::whole(0, cli::kLastTag));
    add->add_option("--tag-size", object_.tag_size, "Edge of a tag's black square [m]")
        ->check(cli::number(0.005, 0.2))
        ->capture_default_str();
    add->add_flag("!--no-picture", object_.picture, "Does not draw it");
    add->add_flag("--force", object_.force, "Overwrites what is there");
  }

  void add_bench() {
    CLI::App* bench = command(app_, "bench", "Benchmarks, each beside its baseline in the same run",
                              [this]() -> int { cli::bench(bench_); });
    bench->add_option("name", bench_.name, "Which: c3 or vision")
        ->check(cli::one_of(cli::bench_names()))
        ->capture_default_str();
    bench->add_option("--filter", bench_.filter,
                      "Regular expression of the benchmarks to run: solve/1_ball");
    bench
        ->add_option("--repetitions", bench_.repetitions,
                     "Times each; the table then has mean and median")
        ->check(cli::whole(1, 1000))
        ->capture_default_str();
    bench->add_option("--json", bench_.json, "File of the results, beside the table");
  }

  CLI::App app_{"c3rt: contact-implicit model predictive control as a real-time service", "c3rt"};
  std::function<int()> action_;
  cli::LaunchOptions launch_, up_, serve_, soaked_, shaken_;
  cli::soak::Settings soak_;
  cli::chaos::Settings chaos_;
  cli::CampaignSettings campaign_;
  cli::TuneSettings tune_;
  cli::gap::Settings gap_;
  cli::ReproduceSettings reproduce_;
  cli::Seat seat_;
  cli::doctor::Settings doctor_;
  cli::latency::Settings latency_;
  cli::keys::Settings keys_;
  cli::LookSettings look_;
  cli::RecordSettings record_;
  cli::ReportSettings report_;
  cli::replay::Settings replay_;
  cli::ViewSettings view_;
  cli::RosSettings ros_;
  std::string recording_, export_to_;  // of export
  std::vector<std::string> topics_;
  bool peers_ = false;
  bool as_keys_ = false, as_json_ = false;
  std::string process_;
  std::string kind_;
  std::vector<std::string> parameters_;
  int index_ = 0;
  double fault_duration_s_ = 1.0;
  std::vector<double> impulse_ns_{0.0, 0.0, 0.0};
  std::vector<double> force_n_{0.0, 0.0, 0.0};
  std::vector<double> collision_torque_nm_, collision_force_n_, contact_torque_nm_,
      contact_force_n_;
  std::vector<std::string> axes_ = kAxes;
  bool elbow_locked_ = false;
  std::string button_;
  double push_s_ = 0.5;
  std::vector<double> position_m_{0.55, 0.0};
  double radius_m_ = 0.1;
  double lead_deg_ = 20.0;
  std::vector<double> points_m_, yaws_deg_;
  double interval_s_ = 2.0, lead_s_ = 0.0;
  bool held_ = false;
  double x_m_ = 0.55, step_m_ = -0.02, y_end_m_ = -0.1, spacing_m_ = 0.08;
  double tolerance_m_ = 0.01, angle_deg_ = 10.0, hold_s_ = 1.0;
  std::string problem_, out_, scenario_;
  std::vector<std::string> overrides_;
  cli::BenchSettings bench_;
  cli::InspectSettings inspect_;
  cli::ObjectAddSettings object_;
};

/// The first files that are opened must not become standard streams that the caller has closed.
/// These stay unusable, so that what is written to them is missed.
void hold_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0) continue;
    (void)open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

/// Whatever has become of standard error.
void say(const std::exception& error) { std::fprintf(stderr, "c3rt: error: %s\n", error.what()); }

/// @throws std::runtime_error where something that was printed did not get there
void flush_standard_output() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw std::runtime_error(std::string("cannot write to standard output: ") +
                           (errno != 0 ? std::strerror(errno) : "something was lost"));
}

}  // namespace

int main(int argc, char** argv) {
  hold_standard_streams();
  const wire::StopFlag stop_flag;
  try {
    const int status = CommandLine().run(argc, argv);
    flush_standard_output();
    return status;
  } catch (const cli::ProcessFailure& error) {
    say(error);
    return cli::kProcessFailed;
  } catch (const cli::UsageError& error) {
    say(error);
    return cli::kUsage;
  } catch (const wire::ProfileError& error) {
    say(error);
    return cli::kUsage;
  } catch (const config::ConfigError& error) {
    say(error);
    return cli::kUsage;
  } catch (const std::exception& error) {
    say(error);
    return cli::kProcessFailed;
  }
}
