#pragma once
// Which commands came in their cycle: the robot's success rate, and when lost ones stop it.
#include <bitset>
#include <cstddef>
#include <cstdint>

#include "plant_emulator/errors.hpp"

namespace c3rt::plant {

constexpr int kLostCommandsMax = 20;     // in a row, then the robot stops
constexpr int kCommandsToRecover = 200;  // two of three have come, then it moves again by itself
constexpr int kSuccessWindow = 100;      // cycles of command_success_rate

/// RT, all of it: no heap, no lock, no throw.
class CommandWatch {
 public:
  /// Commands move the robot from now on.
  void begin() noexcept {
    rest();
    window_at_ = lost_in_a_row_ = 0;
  }
  /// They do not in this cycle.
  void rest() noexcept {
    window_ = 0;
    received_.reset();
  }
  /// A cycle in which they do.
  void count(bool came) noexcept {
    received_[static_cast<std::size_t>(window_at_)] = came;
    window_at_ = (window_at_ + 1) % kSuccessWindow;
    if (window_ < kSuccessWindow) ++window_;
    lost_in_a_row_ = came ? 0 : lost_in_a_row_ + 1;
    if (!came) ++lost_;
  }
  /// Before such a cycle is counted: finds that too many are lost with this one.
  void judge(bool came, Findings& findings) const noexcept {
    if (came || lost_in_a_row_ + 1 < kLostCommandsMax) return;
    findings.add({Error::kCommunicationConstraintsViolation, 0,
                  static_cast<double>(lost_in_a_row_ + 1), static_cast<double>(kLostCommandsMax),
                  "commands lost in a row"});
  }
  /// Whether they are back. @param waits the robot stands because they were lost
  bool back(bool came, bool waits) noexcept {
    if (!waits) back_ = missing_ = 0;
    if (came) {
      ++back_;
    } else if (back_ > 0 && ++missing_ >= kLostCommandsMax + back_ / 2) {
      back_ = missing_ = 0;
    }
    return waits && back_ >= kCommandsToRecover;
  }

  /// Of the last kSuccessWindow cycles in which commands moved the robot, 0..1.
  double success_rate() const noexcept {
    return window_ > 0 ? static_cast<double>(received_.count()) / static_cast<double>(window_)
                       : 0.0;
  }
  std::uint64_t lost() const noexcept { return lost_; }

 private:
  std::bitset<kSuccessWindow> received_;
  int window_ = 0;  // cycles counted in received_, at most kSuccessWindow
  int window_at_ = 0;
  int lost_in_a_row_ = 0;
  int back_ = 0, missing_ = 0;  // commands since they came again
  std::uint64_t lost_ = 0;
};

}  // namespace c3rt::plant
