#pragma once
// What `c3rt run` and `c3rt up` share: the scenario, the lock, the folder, the four processes.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/lock.hpp"
#include "cli/supervisor.hpp"
#include "config/scenario.hpp"
#include "idl/dds.hpp"

namespace c3rt::cli {

/// How a person asked for the processes.
struct LaunchSettings {
  std::string verb;      // "run", "up"
  std::string scenario;  // name or path
  bool lockstep = false;
  bool in_process = false;  // the nodes in this process, in lockstep's order, without DDS
  std::uint64_t seed = 1;
  std::vector<std::string> overrides;  // "planner.rate_hz=75"
  std::string out;                     // empty: out/SCENARIO-DATE
  std::uint32_t domain = 0;
  bool any_domain = false;            // the first free one, instead of `domain`
  bool pictures = true, logs = true;  // of c3rt run
  std::string dds_profile = "loopback";
  std::vector<std::string> without;  // processes that a client plays: "planner"
  std::uint64_t session = 0;         // 0: drawn

  const char* clock_name() const { return lockstep ? "lockstep" : "realtime"; }
  bool leaves_out(const std::string& process) const;
};

/// A process failed or never came up: exit status 3.
class ProcessFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Everything checked, the domain locked, the folder made; nothing started yet.
class Launch {
 public:
  /// @throws UsageError, config::ConfigError
  explicit Launch(const LaunchSettings& settings);

  /// Looks on the bus whether somebody else's processes are there, which no lock of ours tells.
  /// Who plays a process that is left out may be there already.
  /// @throws UsageError that names them, wire::ProfileError for a profile that is refused
  void require_free_bus() const;

  /// Starts the four processes, but for those that are left out, each with its log in out()/logs.
  /// @param recorded lockstep: the plant waits for the recorder, too
  void start(Supervisor& supervisor, bool recorded) const;
  /// Starts one of them anew, in the same session.
  void restart(Supervisor& supervisor, const std::string& name) const;

  bool lockstep() const { return settings_.lockstep; }
  const std::vector<std::string>& without() const { return settings_.without; }
  bool leaves_out(const std::string& name) const { return settings_.leaves_out(name); }
  int process_count() const;  // that are ours
  const std::string& profile() const { return settings_.dds_profile; }
  const config::Scenario& scenario() const { return scenario_; }
  const std::filesystem::path& file() const { return file_; }  // of the scenario
  const std::filesystem::path& out() const { return out_; }
  const wire::BusSettings& bus() const { return bus_; }
  DomainLock& lock() { return *lock_; }  // none where the nodes are in this process
  /// Leaves the domain to somebody whom this process starts.
  void unlock() { lock_.reset(); }
  /// The words of `c3rt serve` that runs the same in the same session.
  std::vector<std::string> serve_words() const;

 private:
  void lock_domain();
  ChildSpec spec_of(const std::string& name, bool recorded) const;

  LaunchSettings settings_;
  std::filesystem::path file_;
  config::Scenario scenario_;
  std::filesystem::path out_;
  wire::BusSettings bus_;
  std::unique_ptr<DomainLock> lock_;
};

/// "planner was killed by signal 11 (Segmentation fault)", with the end of its log below.
std::string failure_text(const ChildExit& end);

}  // namespace c3rt::cli
