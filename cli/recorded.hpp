#pragma once
// What a recording is of: told at its beginning, read from it again.
#include <cstdint>
#include <string>
#include <vector>

#include "cli/recording/recording.hpp"
#include "config/scenario.hpp"

namespace c3rt::cli {

/// Told at the beginning, so that a recording that is cut off tells it, too.
struct Recorded {
  std::string scenario;                // name
  std::string file;                    // of the scenario, from where what it names is found
  std::vector<std::string> overrides;  // of it
  std::uint64_t seed = 0;
  std::string clock;  // "realtime", "lockstep"
};
void tell(Recording& recording, const Recorded& of);

/// On standard error: what is wrong with a recording.
void tell_of(const Contents& contents, const std::string& file);

/// A value of its metadata, "" if it has none.
std::string text_of(const Contents& contents, const char* metadata, const char* key);

/// Of its scenario, in effect in the attachment already; none if it tells none.
std::vector<std::string> overrides_of(const Contents& contents);

/// 1 if it tells none.
std::uint64_t seed_of(const Contents& contents);

/// That of the recording, or the one that is named.
/// @param file of the recording @param scenario name or path; empty: that of the recording
/// @throws UsageError if neither tells one, config::ConfigError
config::Scenario scenario_of(const Contents& contents, const std::string& file,
                             const std::string& scenario,
                             const std::vector<std::string>& overrides);

}  // namespace c3rt::cli
