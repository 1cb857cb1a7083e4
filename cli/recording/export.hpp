#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "cli/recording/recording.hpp"

namespace c3rt::cli {

/// The samples of a recording as one table a topic: robot_state.csv of robot/state, see TopicCsv.
/// @param topics empty: all that it has @param folder that is there
/// @throws mcap::Error if the file is no recording, std::runtime_error where the disk has no room
Contents write_csv(const std::filesystem::path& file, const std::vector<std::string>& topics,
                   const std::filesystem::path& folder);

}  // namespace c3rt::cli
