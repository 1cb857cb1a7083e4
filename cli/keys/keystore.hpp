#pragma once
// A folder with the keys of a secure bus: made at once, and looked at before anything starts.
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/paths.hpp"

namespace c3rt::cli::keys {

/// Hosts whose clocks are so far behind the one that made the keys may use them at once [s].
constexpr std::time_t kClockSkew = 3600;

/// Makes an authority, an identity for each process and for clients, and what each may do, signed.
/// All or nothing: it appears under its name when it is complete. Private files have the mode 0600.
/// @param days until all of it expires
/// @param force replaces a keystore that is there, never another folder
/// @throws UsageError, std::runtime_error where the files cannot be written
void make(const std::filesystem::path& given, int days, bool force, std::time_t now);

/// Something about the keys of an identity, or of all where `identity` is "".
struct Complaint {
  std::string identity;
  std::string text;    // "the certificate of planner expired on 2026-11-29 12:00:00 UTC, …"
  std::string advice;  // what to do about it
};

struct Findings {
  std::vector<Complaint> problems;
  std::time_t expires = 0;  // the first of all that looked at has; 0: nothing could be read
};

/// Looks at what these identities need to join: missing, unreadable or open to others, expired, not
/// yet valid, signed by another authority, or not what this version's topics need.
Findings check(const std::filesystem::path& folder, const std::vector<std::string>& identities,
               std::time_t now);

/// Nothing where the profile (a file) is not secure. @throws UsageError that says all that is wrong
/// with the keys of these identities, and what to do about it
void require_keys(const std::filesystem::path& profile, const std::vector<std::string>& identities);

/// "plant", "impedance", "planner", "vision", "client"
std::vector<std::string> identity_names();

/// "2026-11-29 12:00:00 UTC"
std::string date(std::time_t time);

}  // namespace c3rt::cli::keys
