#pragma once
// The options of c3rt keys.
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/checks.hpp"
#include "cli/keys/keys.hpp"
#include "cli/keys/keystore.hpp"

namespace c3rt::cli::keys {

constexpr int kLongestDays = 36500;

inline void add_folder(CLI::App& command, Settings& settings, const std::string& name) {
  command.add_option(name, settings.folder,
                     "The keystore; default: C3RT_KEYS, else ~/.config/c3rt/keys");
}

inline void add_init_options(CLI::App& command, Settings& settings) {
  add_folder(command, settings, "--out");
  command.add_option("--days", settings.days, "Until they expire")
      ->check(whole(1, kLongestDays))
      ->capture_default_str();
  command.add_flag("--force", settings.force, "Replaces keys that are there");
}

inline void add_check_options(CLI::App& command, Settings& settings) {
  command.add_option("identities", settings.identities, "Of whom; default: of all")
      ->check(one_of(identity_names()));
  add_folder(command, settings, "--keys");
}

}  // namespace c3rt::cli::keys
