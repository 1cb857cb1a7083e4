#pragma once
// Which of the targets that clients asked for the planner took last.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "idl/topics.hpp"

namespace c3rt::cli {

/// Targets and the answers to them come on two topics, of which either may come first: a client
/// that has just begun is found by its target's readers at different times.
class TakenTarget {
 public:
  void asked(const wire::TaskTarget& target) {
    // nobody answers what asks for no reply
    if (target.request_id == 0 || taken(target.request_id)) target_ = target;
    asked_[next_asked_++ % kRemembered] = target;
  }
  void answered(const wire::ServiceReply& reply) {
    if (reply.request_id == 0 || !reply.ok || reply.process != c3rt_v2_PROCESS_PLANNER) return;
    for (const wire::TaskTarget& target : asked_) {
      if (target.request_id == reply.request_id) target_ = target;
    }
    taken_[next_taken_++ % kRemembered] = reply.request_id;
  }
  const std::optional<wire::TaskTarget>& target() const { return target_; }

 private:
  static constexpr std::size_t kRemembered = 16;  // as many as either topic keeps for who is late

  bool taken(std::uint64_t request_id) const {
    return std::find(taken_.begin(), taken_.end(), request_id) != taken_.end();
  }

  std::optional<wire::TaskTarget> target_;
  std::array<wire::TaskTarget, kRemembered> asked_{};
  std::array<std::uint64_t, kRemembered> taken_{};
  std::size_t next_asked_ = 0, next_taken_ = 0;
};

}  // namespace c3rt::cli
