#pragma once
// What a soak amounts to: soak.json and soak.txt, and the files that grow with it: passes.csv, a
// line for each pass, and processes.csv, a line for each look at a process. A picture of memory
// over time.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/invariants/processes.hpp"
#include "cli/invariants/violations.hpp"

namespace c3rt::cli::soak {

/// A curve of bounded size: of a long one every second, fourth, … point.
class Thinned {
 public:
  static constexpr std::size_t kMost = 2000;
  void add(double x, double y);
  const std::vector<std::pair<double, double>>& points() const noexcept { return points_; }

 private:
  std::vector<std::pair<double, double>> points_;
  std::uint64_t every_ = 1, count_ = 0;
};

/// One pass of the task.
struct Pass {
  std::uint64_t number = 0, seed = 0;
  double duration = 0.0;  // of the session's clock [s]
  int loops = 0;
  bool whole = false;  // it came to its own end: then its criteria are judged
  bool met = false;
  std::uint64_t violations = 0;
  std::string log_hash;  // in simulated time
};

struct Summary {
  std::string scenario, clock;  // "realtime", "lockstep", "lockstep in one process"
  std::uint64_t seed = 0;
  std::string result;   // "passed", "violated", "interrupted", what failed
  double soaked = 0.0;  // of the session's clock [s]
  double wall = 0.0;    // [s]
  std::uint64_t passes = 0, whole = 0, met = 0;
  std::uint64_t samples = 0, reflexes = 0;
  std::string details;             // of what failed
  std::vector<std::string> again;  // commands that show the first violations again
};

nlohmann::ordered_json to_json(const invariants::Violations& violations);
nlohmann::ordered_json to_json(const std::map<std::string, invariants::Processes::Course>& courses);
nlohmann::ordered_json to_json(const Summary& summary, const invariants::Violations& violations,
                               const std::map<std::string, invariants::Processes::Course>& courses);

/// The same for a person.
std::string to_text(const Summary& summary, const invariants::Violations& violations,
                    const std::map<std::string, invariants::Processes::Course>& courses);

/// Of violations alone, in lines.
std::string to_text(const invariants::Violations& violations);

/// The end of a long run on the terminal: its text, why there is no picture, where the report is,
/// and what failed; empty: nothing did.
void say_end(const std::string& text, const std::string& missing, const std::filesystem::path& out,
             const std::string& failure);

/// A length of time for a person: "12.0 s", "3.5 min", "24.00 h".
std::string time_text(double seconds);

/// The two files that grow with the soak, on the disk and not in memory.
class Files {
 public:
  /// @param of_passes false: there is no passes.csv, and no pass is added
  /// @throws std::runtime_error where they cannot be written
  explicit Files(const std::filesystem::path& folder, bool of_passes = true);
  void add(const Pass& pass);
  void add(double time, const invariants::ProcessSample& sample);
  /// Lines for which there was no room.
  std::uint64_t lost() const noexcept { return lost_; }
  /// Of each process, memory in MiB over time in s.
  const std::map<std::string, Thinned>& memory() const noexcept { return memory_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  using File = std::unique_ptr<std::FILE, Close>;
  static File made(const std::filesystem::path& path, const char* head);
  void put(std::FILE* file, const std::string& line);
  File passes_, processes_;
  std::uint64_t lost_ = 0;
  std::map<std::string, Thinned> memory_;
};

/// memory.png. @return what is missing and why; empty if it is there
std::string draw_memory(const std::filesystem::path& folder, const std::string& title,
                        const std::map<std::string, Thinned>& memory);

}  // namespace c3rt::cli::soak
