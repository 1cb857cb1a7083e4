#pragma once
// The one report of `c3rt latency`: text, latency.json, latency.png.
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/latency/analysis.hpp"

namespace c3rt::cli::latency {

// what was measured in it
constexpr const char* kAloneStage = "machine alone";
constexpr const char* kDdsStage = "DDS, half a round trip";
constexpr const char* kProcessStage = "four processes";

/// A measured time with its place in report and picture.
struct Row {
  std::string key;  // "wakeup_loop_s" of latency.json
  std::string stage;
  std::string name;  // for a person
  Distribution times;
  std::vector<double> samples;  // [s]; empty where only the quantiles are known
};

struct Report {
  std::string scenario, profile;
  double duration = 0.0;  // as asked [s]
  int load = 0;           // busy threads
  int cores = 0;
  std::string kernel, clock_source;
  bool real_time = false;  // SCHED_FIFO was granted
  std::vector<Row> rows;
  std::uint64_t pings = 0, pings_lost = 0;
  Measured measured;
  Judgement judgement;
  // of the picture: while the processes ran
  std::vector<Wakeup> loop, reference;
};

nlohmann::ordered_json to_json(const Report& report);
std::string text(const Report& report);
/// Draws latency.png. @return what is missing and why; empty if it is there
std::string draw(const std::filesystem::path& file, const Report& report);

}  // namespace c3rt::cli::latency
