#pragma once
// The options of c3rt tune.
#include <limits>

#include <CLI/CLI.hpp>

#include "cli/campaign/options.hpp"
#include "cli/checks.hpp"
#include "cli/tune/tune.hpp"

namespace c3rt::cli::tune {

inline void add_options(CLI::App& command, Settings& settings) {
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
  command.add_option("--seeds", settings.seeds, "On which candidates are judged: 101..104, or 7,9")
      ->capture_default_str();
  command
      .add_option("--test-seeds", settings.test_seeds,
                  "On which start and result are compared in the end; none of --seeds")
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
  campaign::add_engine_options(command, settings, "the same command goes on where it was ended");
}

}  // namespace c3rt::cli::tune
