#pragma once
// Every invariant at work: what the recorder's thread hears and what others add, one at a time.
#include <cstdint>
#include <mutex>
#include <optional>

#include "cli/invariants/processes.hpp"
#include "cli/invariants/samples.hpp"
#include "cli/invariants/violations.hpp"
#include "cli/recorder.hpp"

namespace c3rt::cli::soak {

class Watch : public Listener {
 public:
  void hear(const wire::Plan& sample) override { look(sample); }
  void hear(const wire::Scene& sample) override { look(sample); }
  void hear(const wire::ObjectEstimate& sample) override { look(sample); }
  void hear(const wire::RobotState& sample) override { look(sample); }
  void hear(const wire::RobotCommand& sample) override { look(sample); }
  void hear(const wire::ServiceStatus& sample) override { look(sample); }

  /// Everything else, while nothing is heard.
  template <typename Action>
  auto with(Action&& action) {
    const std::lock_guard lock(mutex_);
    return action(*this);
  }

  /// Of what was heard up to now, and of what comes.
  void begin_streams(const invariants::Limits& limits, const task::Task& task) {
    const std::lock_guard lock(mutex_);
    if (samples) {
      samples_before += samples->samples();
      reflexes_before += samples->reflexes();
    }
    samples.emplace(limits, task, violations);
  }
  std::uint64_t samples_heard() const {
    return samples_before + (samples ? samples->samples() : 0);
  }
  std::uint64_t reflexes_seen() const {
    return reflexes_before + (samples ? samples->reflexes() : 0);
  }

  invariants::Violations violations;
  invariants::Processes processes{{}, violations};
  std::optional<invariants::Samples> samples;
  std::uint64_t samples_before = 0, reflexes_before = 0;  // of earlier streams

 private:
  template <typename T>
  void look(const T& sample) {
    const std::lock_guard lock(mutex_);
    if (samples) samples->hear(sample);
  }
  std::mutex mutex_;
};

}  // namespace c3rt::cli::soak
