#pragma once
// What clients ask of the plant, carried from the thread that talks DDS to the thread that steps,
// and what has become of it, carried back.
#include <array>
#include <atomic>
#include <cstdint>

#include <Eigen/Core>

#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

enum class OrderKind {
  kRecover,
  kStop,
  kPushObject,
  kDropCommands,
  kStall,
  kNan,
  kEndFaults,
  // those that are answered once the robot has obeyed, or has not
  kGuide,
  kRelease,  // by the hand that guides it
  kPressStop,
  kReleaseStop,
  kThresholds,
  kPushArm,
};

/// Whether the robot says what has become of it.
constexpr bool is_answered(OrderKind kind) noexcept { return kind >= OrderKind::kGuide; }

struct Order {
  OrderKind kind;
  int index;              // of an object
  double duration;        // [s]
  Eigen::Vector3d value;  // impulse [N s], force of a hand on the arm [N], in W
  std::uint64_t request_id = 0;
  GuidingAxes axes{};
  CollisionBehavior behavior{};
};

/// What has become of an order.
enum class Outcome {
  kObeyed,
  kMoves,        // it does not while something moves the robot
  kStopPressed,  // it does not while the stop button is pressed
  kRefused,      // the robot behind the door does not, the log tells why
};

struct Answered {
  std::uint64_t request_id;
  OrderKind kind;
  Outcome outcome;
};

/// Bounded queue from one thread to one other; both sides wait-free.
template <typename T>
class Queue {
 public:
  static constexpr std::uint32_t kSize = 32;

  /// @return false if it is full. RT: no heap, no lock, no throw.
  [[nodiscard]] bool put(const T& item) noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == kSize) return false;
    items_[tail % kSize] = item;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }
  /// @return false, and `out` untouched, if it is empty. RT: no heap, no lock, no throw.
  [[nodiscard]] bool take(T& out) noexcept {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    out = items_[head % kSize];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, kSize> items_{};
  std::atomic<std::uint32_t> head_{0}, tail_{0};
};

}  // namespace c3rt::plant
