#pragma once
// The options of everything that runs a scenario.
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "cli/checks.hpp"
#include "cli/example/run.hpp"
#include "cli/example/scenario.hpp"
#include "cli/launch.hpp"
#include "cli/paths.hpp"

namespace c3rt::cli {

/// Of c3rt run, up, serve, soak and chaos.
struct LaunchOptions {
  LaunchSettings settings;
  double duration_s = 0.0;

  void add_to(CLI::App& command) {
    add_scenario_to(command);
    command
        .add_option("--duration", duration_s,
                    "Ends the run after this long [s]; default: the scenario's")
        ->check(number(0.1, 1e6));
  }

  /// The same without the length of a run.
  void add_scenario_to(CLI::App& command) {
    command_ = &command;
    command.add_option("scenario", settings.scenario, "Name of a scenario, or a path to its file")
        ->required();
    command.add_option("--clock", clock_, "realtime or lockstep")
        ->check(one_of({"realtime", "lockstep"}))
        ->capture_default_str();
    command.add_option("--seed", settings.seed, "Seed of every random number")
        ->check(whole(0, std::numeric_limits<long long>::max()))
        ->capture_default_str();
    add_overrides(command, settings.overrides);
    command.add_option("--out", settings.out,
                       "Folder of logs and results; default: out/SCENARIO-DATE");
    command.add_option("--domain", domain_, "DDS domain, 0 to 230, or any: the first that is free")
        ->check(whole_or(0, 230, "any"))
        ->capture_default_str();
    command
        .add_option("--profile,--dds", settings.dds_profile,
                    "DDS profile: a name of config/dds or a path")
        ->capture_default_str();
  }

  LaunchSettings read(const std::string& verb) {
    if (deciding_.exact_limit || deciding_.trace) {
      throw UsageError(
          fmt::format("--exact, --trace: of numerical examples, {} is none", settings.scenario));
    }
    settings.verb = verb;
    if (settings.in_process) refuse_what_needs_a_bus();
    settings.lockstep = settings.in_process || clock_ == "lockstep";
    settings.any_domain = domain_ == "any";
    if (settings.any_domain && verb == "up")
      throw UsageError("--domain any: not for a service, which is found by its number");
    settings.domain = settings.any_domain ? 0 : static_cast<std::uint32_t>(std::stoul(domain_));
    if (duration_s > 0.0)
      settings.overrides.push_back(fmt::format("task.duration_s={}", duration_s));
    if (settings.leaves_out("plant")) require_no_simulation(verb);
    return settings;
  }

  /// Of c3rt run, up and serve.
  void add_without_to(CLI::App& command) {
    command
        .add_option("--without", settings.without,
                    "Leaves a process out, which a client plays: planner, vision or impedance "
                    "(docs/clients.md), up also plant (docs/real_robot.md); several with a comma "
                    "between them")
        ->delimiter(',')
        ->check(one_of({"planner", "vision", "impedance", "plant"}));
  }

  /// Of c3rt run, soak and chaos.
  void add_in_process_to(CLI::App& command) {
    command.add_flag(
        "--in-process", settings.in_process,
        "The same nodes in one process, in simulated time and without DDS: the samples "
        "and the log_hash of --clock lockstep, many times sooner");
    command.add_flag("!--no-pictures", settings.pictures, "Draws nothing");
  }

  /// Of c3rt run alone.
  void add_results_to(CLI::App& command) {
    add_in_process_to(command);
    command.add_flag("!--no-logs", settings.logs, "Keeps no samples (run.mcap): the report alone");
  }

  /// Of c3rt run, for numerical examples.
  void add_deciding_to(CLI::App& command) {
    command
        .add_option("--exact", deciding_.exact_limit,
                    "Of a numerical example: the exact search over the whole horizon decides in "
                    "C3's place, at most so long each time [s]")
        ->check(number(0.001, 86400.0));
    command.add_flag("--trace", deciding_.trace,
                     "Of a numerical example: also every iterate of the first decision "
                     "(iterates.csv), and the time of one projection in each (decisions.csv)");
  }

  /// The same for a numerical example, if the scenario is one.
  /// @throws UsageError, config::ConfigError
  std::optional<ExampleSettings> read_example() const {
    const std::filesystem::path file = scenario_path(settings.scenario);
    if (!is_example(file)) return std::nullopt;
    for (const char* option : {"--clock", "--in-process", "--domain", "--dds", "--no-pictures",
                               "--no-logs", "--without"}) {
      if (command_->count(option) > 0) {
        throw UsageError(
            fmt::format("{}: {} is a numerical example: it runs in this process, in its own time, "
                        "without a bus",
                        option, settings.scenario));
      }
    }
    if (deciding_.exact_limit && deciding_.trace)
      throw UsageError("--trace: of C3 alone, which does not decide with --exact");
    ExampleSettings example{file, settings.seed, settings.overrides, settings.out, deciding_};
    if (duration_s > 0.0)
      example.overrides.push_back(fmt::format("control.duration_s={}", duration_s));
    return example;
  }

  /// The same again, for the supervisor that is started anew.
  std::vector<std::string> words() const {
    std::vector<std::string> words{"serve",
                                   settings.scenario,
                                   "--clock=" + clock_,
                                   "--seed=" + std::to_string(settings.seed),
                                   "--domain=" + domain_,
                                   "--dds=" + settings.dds_profile};
    if (!settings.out.empty()) words.push_back("--out=" + settings.out);
    for (const std::string& name : settings.without) words.push_back("--without=" + name);
    for (const std::string& assignment : settings.overrides) words.push_back("--set=" + assignment);
    return words;
  }

 private:
  void require_no_simulation(const std::string& verb) const {
    if (verb == "run") {
      throw UsageError(
          "--without plant: c3rt run judges by the simulation's truth, which no robot tells: c3rt "
          "up, and c3rt record (docs/real_robot.md)");
    }
    if (settings.lockstep)
      throw UsageError("--without plant: in lockstep the plant's simulated time drives all");
  }
  void refuse_what_needs_a_bus() const {
    for (const char* option : {"--domain", "--dds"}) {
      if (command_->count(option) > 0)
        throw UsageError(fmt::format("{}: --in-process runs without DDS", option));
    }
    if (!settings.without.empty())
      throw UsageError("--without: --in-process runs without DDS, so no client can join");
    if (command_->count("--clock") > 0 && clock_ != "lockstep")
      throw UsageError("--clock realtime: --in-process runs in simulated time");
  }

  CLI::App* command_ = nullptr;
  std::string clock_ = "realtime", domain_ = "0";
  Deciding deciding_;
};

}  // namespace c3rt::cli
