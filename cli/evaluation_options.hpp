#pragma once
// The options of c3rt campaign, c3rt tune and c3rt reproduce.
#include <limits>

#include <CLI/CLI.hpp>

#include "cli/checks.hpp"
#include "cli/evaluation.hpp"

namespace c3rt::cli {

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

inline void add_options(CLI::App& command, CampaignSettings& settings) {
  command.add_option("scenario", settings.scenario, "Name of a scenario, or a path to its file")
      ->required();
  command.add_option("--seeds", settings.seeds, "Numbers and ranges: 1..50, or 1,5,9..12")
      ->capture_default_str();
  add_overrides(command, settings.overrides);
  command.add_option("--out", settings.out, "Folder of results; default: out/campaign-SCENARIO");
  command.add_flag("--logs", settings.logs, "Keeps the samples of each run (0.7 MB a second)");
  command.add_flag("--pictures", settings.pictures, "Draws the pictures of each run");
  command.add_flag("--in-process", settings.in_process,
                   "Each run in one process without DDS: the same figures many times sooner");
  add_engine_options(command, settings,
                     "those of an earlier call with the same scenario, settings and programs are "
                     "kept");
}

inline void add_options(CLI::App& command, TuneSettings& settings) {
  const auto list = [&command](const char* name, std::vector<std::string>& values,
                               const char* text) {
    command.add_option(name, values, text)->expected(1)->take_all();
  };
  command.add_option("scenario", settings.scenario, "Name of a scenario, or a path to its file")
      ->required();
  list("--linear", settings.linear,
       "A number to look for, KEY=LOW..HIGH, or KEY,KEY=LOW..HIGH where several share it");
  list("--log", settings.log, "The same, by its logarithm: of what is known by its size alone");
  list("--whole", settings.whole, "The same, whole numbers");
  command.add_option("--minimise", settings.minimise,
                     "Figure of report.json that is to be small once all criteria are met, as the "
                     "table of c3rt campaign names it");
  command.add_option("--maximise", settings.maximise, "The same, to be large");
  list("--set", settings.overrides,
       "Overrides one key of the scenario, where the search begins: section.key=value");
  list("--search-set", settings.search_overrides,
       "The same for the generations alone, so that a run takes less: final and test have the "
       "scenario whole");
  command.add_option("--seeds", settings.seeds, "On which candidates are judged: 101..104, or 7,9")
      ->capture_default_str();
  command
      .add_option("--finalists", settings.finalists,
                  "The best candidates of all generations, judged once more on --final-seeds; the "
                  "best of them is what is found. 1: the best on --seeds is")
      ->check(whole(1, 1000))
      ->capture_default_str();
  command.add_option("--final-seeds", settings.final_seeds, "None of --seeds")
      ->capture_default_str();
  command
      .add_option("--test-seeds", settings.test_seeds,
                  "On which start and result are compared in the end; none that was used before")
      ->capture_default_str();
  command.add_option("--generations", settings.generations, "How many")
      ->check(whole(1, 10000))
      ->capture_default_str();
  command
      .add_option("--population", settings.population,
                  "Candidates of a generation; default: 4 + 3 ln(numbers)")
      ->check(whole(4, 1000));
  command
      .add_option("--sigma", settings.sigma,
                  "How far around the start the first are drawn, as a share of each range")
      ->check(number(0.001, 1.0))
      ->capture_default_str();
  command.add_option("--seed", settings.seed, "Of the search itself")
      ->check(whole(0, std::numeric_limits<std::uint32_t>::max()))
      ->capture_default_str();
  command.add_option("--out", settings.out, "Folder of results; default: out/tune-SCENARIO");
  add_engine_options(command, settings, "the same command goes on where it was ended");
}

inline void add_options(CLI::App& command, ReproduceSettings& settings) {
  command.add_option("what", settings.what, "Which table or figure")
      ->required()
      ->check(one_of(reproduced()));
  command.add_option("--out", settings.out, "Folder of results; default: out/reproduce");
  command.add_flag("--quick", settings.quick, "Short runs: for a look, not for numbers");
  command.add_flag("--fresh", settings.fresh,
                   "Computes everything anew; else what an earlier call finished with the same "
                   "settings is kept");
  command
      .add_option("--seeds", settings.seeds, "Of comparison and push_anything: 1..20, or 1,5,9..12")
      ->capture_default_str();
  command.add_option("--miqp-limit", settings.miqp_limit, "Time limit of each monolithic MIQP [s]")
      ->check(number(0.001, 86400.0))
      ->capture_default_str();
}

}  // namespace c3rt::cli
