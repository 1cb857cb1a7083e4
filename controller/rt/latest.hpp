#pragma once
// The newest value, handed from one thread to another without either ever waiting.
#include <atomic>
#include <cstdint>

namespace c3rt::rt {

/// Newest value from one writer thread to one reader thread; both sides wait-free (triple buffer).
///
/// Each of the three slots belongs to one side at a time: `back_` to the writer, `front_` to the
/// reader, and the one named in `middle_` to nobody. Values that the reader was too slow for are
/// overwritten.
template <typename T>
class Latest {
 public:
  /// Writer thread only. RT: no heap (if T's assignment makes none), no lock, no throw.
  void put(const T& value) noexcept {
    slots_[back_].value = value;
    back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Reader thread only. @return false, and `out` untouched, if nothing was put since the last
  /// take. RT: no heap (if T's assignment makes none), no lock, no throw.
  [[nodiscard]] bool take(T& out) noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    out = slots_[front_].value;
    return true;
  }

 private:
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kFresh = 4;
  static constexpr int kCacheLine = 64;

  // on lines of their own: the two sides share only `middle_`
  struct alignas(kCacheLine) Slot {
    T value{};
  };
  Slot slots_[3];
  alignas(kCacheLine) std::atomic<std::uint32_t> middle_{0};
  alignas(kCacheLine) std::uint32_t back_ = 1;
  alignas(kCacheLine) std::uint32_t front_ = 2;
};

}  // namespace c3rt::rt
