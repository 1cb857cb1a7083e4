#pragma once
// One instance per DDS domain: a lock that the kernel releases however its holder ends, and a note
// of who holds it.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "cli/paths.hpp"

namespace c3rt::cli {

/// What the holder says about itself.
struct Instance {
  pid_t pid = 0;
  std::string verb;      // "run", "up"
  std::string scenario;  // name
  std::string file;      // of the scenario
  std::vector<std::string> overrides;
  std::string clock;  // "realtime", "lockstep"
  std::uint64_t session = 0;
  std::uint64_t seed = 0;
  std::string profile;             // of DDS: a file
  std::string out;                 // its folder
  std::string started;             // local time
  std::string ended;               // how the last one ended; empty while it runs
  std::vector<std::string> notes;  // what a person should know: restarts, a full disk
};

/// Somebody else holds the domain.
class DomainBusy : public UsageError {
 public:
  using UsageError::UsageError;
};

class DomainLock {
 public:
  /// @param patience of a holder that was killed, the last thread may end a moment later
  /// @throws DomainBusy "domain 0 is busy: …" that names the holder
  DomainLock(const std::filesystem::path& directory, std::uint32_t domain, const Instance& self,
             std::chrono::milliseconds patience = std::chrono::seconds(1));
  ~DomainLock();
  DomainLock(const DomainLock&) = delete;
  DomainLock& operator=(const DomainLock&) = delete;

  std::uint32_t domain() const { return domain_; }

  /// Leaves a word for `c3rt status` after this instance.
  void set_ended(const std::string& how);

  /// What `c3rt status` tells of it while it runs.
  void set_notes(const std::vector<std::string>& notes);

 private:
  void write() const;
  std::uint32_t domain_;
  int file_ = -1;
  Instance self_;
};

/// The first free one of the domains that are kept for this (230 down to 101), without a race
/// between programs that look for one at the same time.
/// @throws UsageError if all are busy
std::unique_ptr<DomainLock> lock_any_domain(const std::filesystem::path& directory,
                                            const Instance& self);

/// The instance that holds the domain now.
std::optional<Instance> holder(const std::filesystem::path& directory, std::uint32_t domain);

/// What the last instance left, running or not.
std::optional<Instance> last_instance(const std::filesystem::path& directory, std::uint32_t domain);

}  // namespace c3rt::cli
