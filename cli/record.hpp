#pragma once
// `c3rt record`, `report` and `export`: recordings of a running instance, and what they tell.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/client.hpp"

namespace c3rt::cli {

struct RecordSettings {
  std::string file;
  double duration_s = 0.0;  // 0: until interrupted
  double timeout_s = 5.0;   // without a sample, until it is given up; 0: never
};

/// Every sample of a running instance into a new file, whatever its clock.
/// @return kCriterionFailed where nobody writes, or samples were lost
/// @throws UsageError if the file is there already or cannot be written
int record(const Seat& seat, const RecordSettings& settings);

struct ReportSettings {
  std::string file;
  std::string scenario;  // empty: that of the recording
  std::vector<std::string> overrides;
  std::optional<std::uint64_t> seed;  // none: that of the recording
  std::string out;                    // folder of report.json and pictures; empty: none
  std::string series;                 // folder of write_series; empty: none
};

/// The report of a recording, as its run gave it.
/// @return as the run: kCriterionFailed if a criterion was not met
/// @throws UsageError for a file that is no recording, or that does not tell its scenario
int report_recording(const ReportSettings& settings);

/// The samples of a recording as one CSV file a topic.
/// @param topics empty: all that it has @param out folder; empty: beside the file
/// @throws UsageError
int export_recording(const std::string& file, const std::vector<std::string>& topics,
                     const std::string& out);

}  // namespace c3rt::cli
