#pragma once
// The options of c3rt doctor.
#include <CLI/CLI.hpp>

#include "cli/checks.hpp"
#include "cli/doctor/doctor.hpp"

namespace c3rt::cli::doctor {

inline void add_options(CLI::App& command, Settings& settings) {
  command.add_option("--domain", settings.seat.domain, "DDS domain")
      ->check(whole(0, 230))
      ->capture_default_str();
  command
      .add_option("--profile,--dds", settings.seat.dds_profile,
                  "DDS profile, where no instance of yours tells it")
      ->capture_default_str();
  command.add_flag("--json", settings.json, "Prints the findings as JSON");
}

}  // namespace c3rt::cli::doctor
