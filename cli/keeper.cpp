#include "cli/keeper.hpp"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <thread>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "cli/client.hpp"
#include "cli/guests.hpp"
#include "cli/log_rotation.hpp"
#include "cli/paths.hpp"
#include "controller/rt/periodic_clock.hpp"

namespace c3rt::cli {
namespace {

constexpr double kLookAtDisk = 1.0;  // [s]
// A death is seen within 0.02 s, the reflex that it caused may be told before. [s]
constexpr double kJustBefore = 0.5;
constexpr int kMostRecovers = 5;  // an arm that stops again and again is looked at by a person
constexpr double kBetweenRecovers = 1.0, kRecoverWithin = 15.0, kSettled = 1.5;  // [s]

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string times(int count) { return count == 1 ? "once" : fmt::format("{} times", count); }

}  // namespace

Keeper::Keeper(Launch& launch, Supervisor& supervisor)
    : launch_(launch),
      supervisor_(supervisor),
      bus_(launch.bus()),
      statuses_(bus_, 64),
      targets_(bus_),
      replies_(bus_),
      target_writer_(bus_),
      requests_(bus_) {}

std::optional<ChildExit> Keeper::step() {
  const double now = now_s();
  hear(now);
  while (auto end = supervisor_.take_ended()) {
    // somebody else may have heard of all four a moment earlier
    for (int i = 0; i < 20 && !came_up_ && !launch_.lockstep(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      hear(now_s());
    }
    if (!came_up_ || launch_.lockstep()) return end;
    bury(*end, now);
  }
  start_due(now);
  tell_target();
  recover(now);
  look_at_disk(now);
  return std::nullopt;
}

void Keeper::hear(double now) {
  wire::ServiceStatus status{};
  while (statuses_.take(status)) {
    const auto process = static_cast<std::size_t>(status.process);
    if (process < heard_.size()) heard_[process] = status;
  }
  int count = 0;
  for (const wire::ServiceStatus& each : heard_) {
    const bool ours = !launch_.leaves_out(wire::process_name(each.process));
    count += each.pid != 0 && ours && has_come_up(each, launch_.leaves_out("plant")) ? 1 : 0;
  }
  came_up_ = came_up_ || count >= launch_.process_count();
  if (robot_well()) well_at_ = now;

  wire::TaskTarget target{};
  while (targets_.take(target)) target_.asked(target);
  wire::ServiceReply reply{};
  while (replies_.take(reply)) target_.answered(reply);
}

bool Keeper::robot_well() const {
  return heard(c3rt_v2_PROCESS_PLANT).state == c3rt_v2_SERVICE_RUNNING &&
         heard(c3rt_v2_PROCESS_IMPEDANCE).state == c3rt_v2_SERVICE_RUNNING;
}

/// A planner that was started again knows no target but the scenario's.
void Keeper::tell_target() {
  if (!target_is_due_) return;
  const wire::ServiceStatus& planner = heard(c3rt_v2_PROCESS_PLANNER);
  const Kept& kept = kept_[wire::process_name(c3rt_v2_PROCESS_PLANNER)];
  if (kept.due || planner.pid == kept.pid || !in_service(planner)) return;
  target_is_due_ = false;
  if (!target_.target()) return;
  wire::TaskTarget again = *target_.target();
  again.request_id = 0;
  target_writer_.write(again, rt::now_ns());
}

/// What stopped the robot was that a process had gone, and that has been made good: nobody need
/// come and recover it. Who stopped it by hand before, or after, must.
void Keeper::recover(double now) {
  if (restarted_.empty() || now < recover_next_) return;
  if (now > recover_until_ || (recovers_ == kMostRecovers && !robot_well())) {
    tell("the robot did not recover after " + restarted_ + " was started again: c3rt recover");
    restarted_.clear();
    return;
  }
  for (const auto& [name, kept] : kept_) {
    if (kept.due) return;
    for (const wire::ServiceStatus& status : heard_) {
      // still the words of the one that has died
      if (name == wire::process_name(status.process) && status.pid == kept.pid) return;
    }
  }
  if (!robot_well()) unwell_at_ = now;
  if (robot_well()) {
    // a plan that jumps, or a command that comes too late, shows a moment later
    if (now - unwell_at_ < kSettled) return;
    tell("the robot goes on after " + restarted_ + " was started again");
    restarted_.clear();
    return;
  }
  if (std::string(heard(c3rt_v2_PROCESS_PLANT).text).find("stopped by a person") == 0) {
    restarted_.clear();
    return;
  }
  recover_next_ = now + kBetweenRecovers;
  ++recovers_;
  for (const wire::Process process :
       {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER}) {
    wire::ServiceRequest wanted{};
    wanted.request_id = static_cast<std::uint64_t>(rt::now_ns());
    wanted.process = process;
    wanted.verb = c3rt_v2_REQUEST_RECOVER;
    requests_.write(wanted, rt::now_ns());
  }
}

void Keeper::bury(const ChildExit& end, double now) {
  Kept& kept = kept_[end.name];
  kept.last = end.reason;
  kept.due = kept.policy.died(now);
  kept.given_up = !kept.due.has_value();
  for (const wire::ServiceStatus& status : heard_) {
    if (status.pid != 0 && end.name == wire::process_name(status.process)) kept.pid = status.pid;
  }
  if (end.name == wire::process_name(c3rt_v2_PROCESS_PLANNER)) target_is_due_ = true;
  if (!kept.given_up && (now - well_at_ < kJustBefore || !restarted_.empty())) {
    restarted_ = end.name;
    recovers_ = 0;
    recover_until_ = now + kRecoverWithin;
    unwell_at_ = now;
    recover_next_ = now;
  }
  tell(failure_text(end));
  if (kept.given_up) {
    tell(fmt::format("{} is given up: it has ended {} in {:g} s; the others go on without it",
                     end.name, times(RestartPolicy::kMost + 1), RestartPolicy::kWindow));
  }
  write_notes();
}

void Keeper::start_due(double now) {
  for (auto& [name, kept] : kept_) {
    if (!kept.due || *kept.due > now) continue;
    kept.due.reset();
    try {
      launch_.restart(supervisor_, name);
      tell(name + " is started again");
    } catch (const std::exception& error) {
      kept.last = error.what();
      kept.due = kept.policy.died(now);
      kept.given_up = !kept.due.has_value();
      tell(error.what());
    }
    write_notes();
  }
}

void Keeper::look_at_disk(double now) {
  if (now - disk_seen_ < kLookAtDisk) return;
  disk_seen_ = now;
  std::string unrotated = rotate_logs(launch_.out() / "logs");
  if (unrotated.empty()) unrotated = rotate_log(supervisor_log(launch_.bus().domain));
  if (unrotated != unrotated_ && !unrotated.empty()) tell(unrotated);
  unrotated_ = unrotated;
  const bool full = is_full(launch_.out());
  if (full == disk_full_) return;
  disk_full_ = full;
  tell(full ? "no room is left in " + launch_.out().string() + ": logs lose what is said"
            : "there is room in " + launch_.out().string() + " again");
  write_notes();
}

void Keeper::tell(const std::string& sentence) const {
  fmt::print("{:%H:%M:%S} {}\n", fmt::localtime(std::time(nullptr)), sentence);
  std::fflush(stdout);
}

void Keeper::write_notes() const {
  std::vector<std::string> notes;
  if (!launch_.without().empty()) notes.push_back("waits for " + guests_text(launch_));
  for (const auto& [name, kept] : kept_) {
    const int restarts = kept.policy.deaths() - (kept.due || kept.given_up ? 1 : 0);
    std::string note = restarts > 0 ? fmt::format("{} was started again {}", name, times(restarts))
                                    : name + " has ended";
    note += fmt::format(" ({})", kept.last);
    if (kept.given_up) note += "; it ended too often and is given up: c3rt down, then up";
    notes.push_back(note);
  }
  if (disk_full_)
    notes.push_back("no room is left in " + launch_.out().string() + ": logs lose what is said");
  try {
    launch_.lock().set_notes(notes);
  } catch (const std::exception& error) {
    tell(error.what());  // that they cannot be told is no reason to end the robot's processes
  }
}

}  // namespace c3rt::cli
