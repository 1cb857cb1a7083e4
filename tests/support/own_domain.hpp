#pragma once
// DDS domains of a test's own, as tests run beside each other.
#include <cstdint>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace c3rt::support {

/// A domain that no other test on this machine has: it holds the domain's file until it ends, as
/// tests/support/own_domain.py does. 77 and more are those that tests name.
inline std::uint32_t take_domain() {
  constexpr int kCount = 76;
  for (int i = 0; i < kCount; ++i) {
    const int domain = 1 + (getpid() + i) % kCount;
    const std::string file = "/tmp/c3rt-test-domain-" + std::to_string(domain);
    const int held = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (held < 0) continue;  // another user's
    if (flock(held, LOCK_EX | LOCK_NB) == 0) return static_cast<std::uint32_t>(domain);
    close(held);
  }
  throw std::runtime_error("tests hold all DDS domains from 1 to " + std::to_string(kCount));
}

/// Taken before any fork: a child is in the domain of its parent.
inline const std::uint32_t kOwnDomain = take_domain();

}  // namespace c3rt::support
