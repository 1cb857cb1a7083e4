#pragma once

#include <cstdint>

namespace c3rt::support {

/// Counts the heap calls (malloc, calloc, realloc, aligned_alloc, posix_memalign and what is built
/// on them) of the calling thread between its construction and `count()`. Read `count()` before
/// any Catch macro: Catch itself allocates.
class AllocationCounter {
 public:
  AllocationCounter() noexcept;
  AllocationCounter(const AllocationCounter&) = delete;
  AllocationCounter& operator=(const AllocationCounter&) = delete;

  [[nodiscard]] std::int64_t count() const noexcept;

  /// False under sanitizers, which own malloc: `count()` is then always 0.
  [[nodiscard]] static bool counts() noexcept;

 private:
  std::int64_t start_;
};

}  // namespace c3rt::support
