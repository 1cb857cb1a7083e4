#pragma once
// Logs that go on for as long as a service does, without filling the disk.
#include <cstdint>
#include <filesystem>
#include <string>

namespace c3rt::cli {

constexpr std::uintmax_t kLargestLog = 4 << 20;  // what a log may grow to [bytes]
constexpr int kOlderLogs = 3;                    // kept beside it: NAME.1.log is the newest of them

/// Moves a log that has become too large into NAME.1.log, what was there into NAME.2.log, and so
/// on; the last one goes. Who writes it appends (O_APPEND) and goes on in the same file, which is
/// empty then: no process waits for another one to have its words written. What is written between
/// the copy's end and the cut, some microseconds, is lost.
/// @return why it could not be done; empty: it was, or there was nothing to do
std::string rotate_log(const std::filesystem::path& log, std::uintmax_t largest = kLargestLog,
                       int older = kOlderLogs);

/// The same for each NAME.log of a folder.
std::string rotate_logs(const std::filesystem::path& folder, std::uintmax_t largest = kLargestLog,
                        int older = kOlderLogs);

}  // namespace c3rt::cli
