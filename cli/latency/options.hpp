#pragma once
// The options of c3rt latency.
#include <CLI/CLI.hpp>

#include "cli/checks.hpp"
#include "cli/latency/latency.hpp"

namespace c3rt::cli::latency {

inline void add_options(CLI::App& command, Settings& settings) {
  command.add_option("scenario", settings.scenario, "What the four processes run while measured")
      ->capture_default_str();
  command
      .add_option(
          "--duration", settings.duration,
          "Of the measurement [s]: a sixth the machine alone, a sixth DDS, the rest the four "
          "processes")
      ->check(number(kShortest, kLongest))
      ->capture_default_str();
  command
      .add_option("--load", settings.load,
                  "Ordinary threads that compute all the time beside what is measured")
      ->check(whole(0, 1024))
      ->capture_default_str();
  command
      .add_option("--profile,--dds", settings.profile,
                  "DDS profile: a name of config/dds or a path")
      ->capture_default_str();
  command
      .add_option("--domain", settings.domain, "DDS domain, 0 to 230, or any: the first free one")
      ->check(whole_or(0, 230, "any"))
      ->capture_default_str();
  command.add_option("--out", settings.out, "Folder of the report; default: out/latency-DATE");
  command.add_flag("--json", settings.json, "Prints latency.json instead of the table");
}

}  // namespace c3rt::cli::latency
