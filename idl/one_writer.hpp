#pragma once
// Which of several writers of one topic is obeyed. Pure: time comes in.
#include <cstdint>

namespace c3rt::wire {

/// Strength (DDS: ownership strength) that the writers of c3rt's own processes offer. A client that
/// plays a process offers none (0) and is obeyed while that process is not there.
constexpr std::int32_t kProcessStrength = 100;

/// The rule of a topic with one writer: the greatest strength leads, among equals the first that
/// was heard. One of equal strength takes over when it speaks while the leader is silent, both for
/// `silence_ns`: a single stray sample takes nothing over, and neither does what had piled up while
/// this process itself stood still. A weaker one waits until the leader is known to be gone: who is
/// stalled comes back. RT: no heap, no lock, no throw.
class OneWriter {
 public:
  /// @param silence_ns 0: a leader is never replaced for being silent (lockstep: the machine's time
  /// decides nothing)
  /// @param least_strength weaker writers are never obeyed
  OneWriter(std::int64_t silence_ns, std::int32_t least_strength) noexcept
      : silence_ns_(silence_ns), least_strength_(least_strength) {}

  /// Decides on one sample of that process (DDS: its participant), heard now. @return true if it is
  /// to be obeyed
  bool admits(std::uint64_t writer, std::int32_t strength, std::int64_t now_ns) noexcept {
    if (strength < least_strength_) return false;
    if (writer == leader_) {
      heard_ns_ = now_ns;
      challenged_ = false;
      return true;
    }
    if (leader_ == 0 || strength > strength_ || (strength == strength_ && outlasted(now_ns))) {
      leader_ = writer;
      strength_ = strength;
      heard_ns_ = now_ns;
      challenged_ = false;
      return true;
    }
    return false;
  }
  std::uint64_t leader() const noexcept { return leader_; }  // 0: none yet
  /// Worth asking whether the leader is still there.
  bool leader_is_silent(std::int64_t now_ns) const noexcept {
    return leader_ != 0 && silent(now_ns);
  }
  /// The leader is gone: the next that speaks leads.
  void retire() noexcept { leader_ = 0; }
  /// Another writer leads and is not silent.
  bool has_other_than(std::uint64_t writer, std::int64_t now_ns) const noexcept {
    return leader_ != 0 && leader_ != writer && !silent(now_ns);
  }

 private:
  bool silent(std::int64_t now_ns) const noexcept {
    return silence_ns_ > 0 && now_ns - heard_ns_ > silence_ns_;
  }
  bool outlasted(std::int64_t now_ns) noexcept {
    if (silence_ns_ == 0) return false;
    if (!challenged_) {
      challenged_ = true;
      challenged_since_ns_ = now_ns;
    }
    return silent(now_ns) && now_ns - challenged_since_ns_ > silence_ns_;
  }

  std::int64_t silence_ns_;
  std::int32_t least_strength_;
  std::uint64_t leader_ = 0;
  std::int32_t strength_ = 0;
  std::int64_t heard_ns_ = 0;
  bool challenged_ = false;
  std::int64_t challenged_since_ns_ = 0;
};

}  // namespace c3rt::wire
