#include "cli/chaos/recovery.hpp"

#include <algorithm>
#include <cmath>

#include "controller/base/time.hpp"
#include "idl/text.hpp"

namespace c3rt::cli::chaos {
namespace {

Eigen::Vector3d vector_of(const c3rt_v2_Vec3& value) { return {value[0], value[1], value[2]}; }

void add(Times& times, const Outcome& outcome) {
  ++times.count;
  if (std::isfinite(outcome.at_task)) times.at_task.push_back(outcome.at_task);
  if (std::isfinite(outcome.resumed)) {
    times.resumed.push_back(outcome.resumed);
  } else if (outcome.overtaken) {
    ++times.overtaken;
  } else {
    ++times.not_resumed;
  }
}

void sort(Times& times) {
  std::sort(times.resumed.begin(), times.resumed.end());
  std::sort(times.at_task.begin(), times.at_task.end());
}

/// Killed, stopped, stalled or spoilt itself, not its lines.
bool is_of_process(const Fault& fault) {
  return fault.kind->act == Act::kKill || fault.kind->act == Act::kStop;
}

}  // namespace

void Recovery::forget() {
  followed_ = 0;
  at_task_ = false;
  from_.reset();
  objects_.clear();
}

void Recovery::begin(const Fault& fault, std::int64_t now_ns) {
  if (!outcomes_.empty() && !std::isfinite(outcomes_.back().resumed)) {
    outcomes_.back().overtaken = true;
    if (fault_is_over()) waited_ += base::seconds(now_ns - *end_ns_);
  }
  outcomes_.push_back({fault});
  end_ns_.reset();
  forget();
}

void Recovery::finish() {
  if (!outcomes_.empty() && !std::isfinite(outcomes_.back().resumed) && !told_)
    outcomes_.back().overtaken = true;
}

void Recovery::end(std::int64_t now_ns) {
  end_ns_ = now_ns;
  forget();
}

void Recovery::hear(const wire::Plan& sample) {
  at_task_ =
      fault_is_over() && sample.origin.exposure_ns >= *end_ns_ && wire::is_at_task(sample.phase);
}

void Recovery::hear(const wire::RobotCommand& sample) {
  if (!fault_is_over()) return;
  const std::int64_t oldest_ns =
      std::min({sample.origin.exposure_ns, sample.origin.state_ns, sample.origin.plan_ns});
  const bool follows = sample.mode == c3rt_v2_IMPEDANCE_TRACK && oldest_ns >= *end_ns_;
  if (!follows) {
    followed_ = 0;
    from_.reset();
  } else if (followed_ == 0) {
    followed_ = sample.header.seq;
  }
}

void Recovery::hear(const wire::RobotState& sample) {
  if (!fault_is_over() || std::isfinite(outcomes_.back().resumed)) return;
  const bool follows = followed_ != 0 && sample.mode == c3rt_v2_ROBOT_MOVE &&
                       sample.command_seq >= followed_ && sample.header.time_ns >= *end_ns_;
  if (!follows) {
    from_.reset();
    return;
  }
  if (!from_) from_ = vector_of(sample.p_WE_m);
  if (!((vector_of(sample.p_WE_m) - *from_).norm() > kMoved)) return;
  outcomes_.back().resumed = base::seconds(sample.header.time_ns - *end_ns_);
  waited_ = 0.0;
  told_ = false;
}

void Recovery::hear(const wire::Scene& sample) {
  if (!fault_is_over() || std::isfinite(outcomes_.back().at_task)) return;
  if (!at_task_ || !std::isfinite(outcomes_.back().resumed)) {
    objects_.clear();
    return;
  }
  const auto count = static_cast<std::size_t>(
      std::clamp<int>(static_cast<int>(sample.object_count), 0, c3rt_v2_MAX_OBJECTS));
  if (objects_.size() != count) {
    objects_.clear();
    for (std::size_t i = 0; i < count; ++i) objects_.push_back(vector_of(sample.objects[i].p_WB_m));
  }
  for (std::size_t i = 0; i < count; ++i) {
    if ((vector_of(sample.objects[i].p_WB_m) - objects_[i]).norm() > kMoved)
      outcomes_.back().at_task = base::seconds(sample.header.time_ns - *end_ns_);
  }
}

bool Recovery::lost_patience(std::int64_t now_ns) {
  if (outcomes_.empty() || !fault_is_over() || std::isfinite(outcomes_.back().resumed))
    return false;
  const double waits = base::seconds(now_ns - *end_ns_);
  if (told_ || waited_ + waits <= kPatience) return false;
  told_ = true;
  return true;
}

std::map<std::string, Times> by_kind(const std::vector<Outcome>& outcomes) {
  std::map<std::string, Times> result;
  for (const Outcome& outcome : outcomes) {
    std::string name(outcome.fault.kind->name);
    if (is_of_process(outcome.fault)) name += " " + outcome.fault.target;
    add(result[name], outcome);
  }
  for (auto& [name, times] : result) sort(times);
  return result;
}

Times of_plant(const std::vector<Outcome>& outcomes, bool plant) {
  Times times;
  for (const Outcome& outcome : outcomes) {
    // with the supervisor the plant has gone, too
    const std::string_view target = outcome.fault.target;
    if ((target == "plant" || target == "supervisor") == plant) add(times, outcome);
  }
  sort(times);
  return times;
}

}  // namespace c3rt::cli::chaos
