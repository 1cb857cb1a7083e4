#include "tests/support/allocation_counter.hpp"

#include <cerrno>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define C3RT_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define C3RT_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef C3RT_COUNTS_ALLOCATIONS
#define C3RT_COUNTS_ALLOCATIONS 1
#endif

namespace {
// constant-initialised, so that malloc may be called before any constructor has run
thread_local std::int64_t heap_calls = 0;
}  // namespace

#if C3RT_COUNTS_ALLOCATIONS
// The executable's malloc replaces glibc's for every library in the process; glibc keeps its own
// under these names for exactly this use.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  ++heap_calls;
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  ++heap_calls;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  ++heap_calls;
  return __libc_realloc(p, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  ++heap_calls;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++heap_calls;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  ++heap_calls;
  void* p = __libc_memalign(alignment, size);
  if (p == nullptr) return ENOMEM;
  *out = p;
  return 0;
}
}
#endif

namespace c3rt::support {

AllocationCounter::AllocationCounter() noexcept : start_(heap_calls) {}

std::int64_t AllocationCounter::count() const noexcept { return heap_calls - start_; }

bool AllocationCounter::counts() noexcept { return C3RT_COUNTS_ALLOCATIONS == 1; }

}  // namespace c3rt::support
