#pragma once
// The options of c3rt campaign.
#include <CLI/CLI.hpp>

#include "cli/campaign/campaign.hpp"
#include "cli/checks.hpp"

namespace c3rt::cli::campaign {

/// How runs are made. @param fresh what is kept without it
inline void add_engine_options(CLI::App& command, EngineSettings& settings,
                               const std::string& fresh) {
  command
      .add_option("--duration", settings.duration,
                  "Ends each run after this long [s]; default: the scenario's")
      ->check(number(0.1, 1e6));
  command.add_option("--jobs,-j", settings.at_once, "Runs at once; default: one for each core")
      ->check(whole(1, 130));
  command.add_flag("--fresh", settings.fresh, "Makes every run anew; else " + fresh);
  command
      .add_option("--engine", settings.engine,
                  "local, or dask: workers on this or on other machines")
      ->check(one_of({"local", "dask"}))
      ->capture_default_str();
  command.add_option("--address", settings.address,
                     "Of Dask's scheduler, tcp://host:port; default: workers on this machine");
}

inline void add_options(CLI::App& command, Settings& settings) {
  command.add_option("scenario", settings.scenario, "Name of a scenario, or a path to its file")
      ->required();
  command.add_option("--seeds", settings.seeds, "Numbers and ranges: 1..50, or 1,5,9..12")
      ->capture_default_str();
  command
      .add_option("--set", settings.overrides,
                  "Overrides one key of the scenario: section.key=value")
      ->expected(1)
      ->take_all();
  command.add_option("--out", settings.out, "Folder of results; default: out/campaign-SCENARIO");
  command.add_flag("--logs", settings.logs, "Keeps the samples of each run (0.7 MB a second)");
  command.add_flag("--pictures", settings.pictures, "Draws the pictures of each run");
  command.add_flag("--in-process", settings.in_process,
                   "Each run in one process without DDS: the same figures many times sooner");
  add_engine_options(command, settings,
                     "those of an earlier call with the same scenario, settings and programs are "
                     "kept");
}

}  // namespace c3rt::cli::campaign
