#pragma once
// Keeps the four processes of a service running.
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/launch.hpp"
#include "cli/restart_policy.hpp"
#include "cli/supervisor.hpp"
#include "cli/taken_target.hpp"
#include "idl/dds.hpp"

namespace c3rt::cli {

/// Looks after them, step by step: who has died is started again (RestartPolicy) and told the
/// target that it had; a robot that was well before is recovered; who dies too often is given up
/// and the others go on without it. What happened is told in the instance's notes, which `c3rt
/// status` prints, and on standard output.
class Keeper {
 public:
  Keeper(Launch& launch, Supervisor& supervisor);

  /// One look at everything. @return the end of a process that nothing can make good: one that
  /// ended before all four had come up, or any in lockstep, whose time cannot be joined again
  std::optional<ChildExit> step();

 private:
  struct Kept {
    RestartPolicy policy;
    std::optional<double> due;  // when it is started again
    bool given_up = false;
    std::string last;  // how it ended last
    int pid = 0;       // of the one that has ended
  };
  void hear(double now);
  void bury(const ChildExit& end, double now);
  void start_due(double now);
  void look_at_disk(double now);
  void tell_target();
  void recover(double now);
  bool robot_well() const;
  const wire::ServiceStatus& heard(wire::Process process) const {
    return heard_[static_cast<std::size_t>(process)];
  }
  void tell(const std::string& sentence) const;
  void write_notes() const;

  Launch& launch_;
  Supervisor& supervisor_;
  std::map<std::string, Kept> kept_;
  bool came_up_ = false;  // all four have been in service
  bool disk_full_ = false;
  double disk_seen_ = 0.0;
  std::string unrotated_;  // why a log could not be begun anew; told once
  wire::Bus bus_;
  wire::Reader<wire::ServiceStatus> statuses_;
  wire::Reader<wire::TaskTarget> targets_;
  wire::Reader<wire::ServiceReply> replies_;
  wire::Writer<wire::TaskTarget> target_writer_;
  wire::Writer<wire::ServiceRequest> requests_;
  std::array<wire::ServiceStatus, wire::kProcessCount> heard_{};  // the newest of each, pid 0: none
  TakenTarget target_;
  double well_at_ = -1e9;       // the robot was well
  std::string restarted_;       // who was started again while the robot was well; empty: nobody
  bool target_is_due_ = false;  // of a planner that was started again
  int recovers_ = 0;            // asked for since then
  double recover_until_ = 0.0, recover_next_ = 0.0, unwell_at_ = 0.0;
};

}  // namespace c3rt::cli
