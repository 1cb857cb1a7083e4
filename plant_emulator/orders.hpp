#pragma once
// What clients ask of the plant, carried from the thread that talks DDS to the thread that steps.
#include <array>
#include <atomic>
#include <cstdint>

#include <Eigen/Core>

namespace c3rt::plant {

enum class OrderKind { kRecover, kStop, kPushObject, kDropCommands, kStall, kNan, kEndFaults };

struct Order {
  OrderKind kind;
  int index;              // of an object
  double duration;        // [s]
  Eigen::Vector3d value;  // impulse [N s]
};

/// Bounded queue from one thread to one other; both sides wait-free.
class OrderQueue {
 public:
  /// @return false if it is full
  [[nodiscard]] bool put(const Order& order) noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == kSize) return false;
    orders_[tail % kSize] = order;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }
  /// @return false, and `out` untouched, if it is empty. RT: no heap, no lock, no throw.
  [[nodiscard]] bool take(Order& out) noexcept {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    out = orders_[head % kSize];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

 private:
  static constexpr std::uint32_t kSize = 32;
  std::array<Order, kSize> orders_{};
  std::atomic<std::uint32_t> head_{0}, tail_{0};
};

}  // namespace c3rt::plant
