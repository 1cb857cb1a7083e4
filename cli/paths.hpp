#pragma once
// Where things are: seen from the binary, so that a build tree and an installed tree both work from
// any directory.
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace c3rt::cli {

/// The person asked for something that does not exist or does not fit: exit status 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The folder of this program.
std::filesystem::path binary_directory();

/// Where c3rt-plant and the others are: beside this program, or C3RT_PROCESS_DIRECTORY.
std::filesystem::path process_directory();

/// The named scenarios, sorted.
std::vector<std::string> scenario_names();

/// A scenario's file from its name or its path. @throws UsageError that lists the known names
std::filesystem::path scenario_path(const std::string& scenario);

/// A DDS profile's file from its name (loopback, lan, secure) or its path. @throws UsageError that
/// lists the known names
std::filesystem::path dds_profile_path(const std::string& profile);

/// Holds the locks of this user: XDG_RUNTIME_DIR/c3rt, else c3rt-UID in the folder for temporary
/// files. Made if missing.
std::filesystem::path runtime_directory();

/// What the supervisor of the service on this domain says, who has no terminal.
std::filesystem::path supervisor_log(unsigned domain);

/// out/NAME-DATE under the current directory, with a number where that is taken; not made.
std::filesystem::path new_folder(const std::string& name);

/// Makes the folder and those above it. @return its absolute path. @throws UsageError
std::filesystem::path make_folder(const std::filesystem::path& folder);

/// The folder takes this much now. @throws std::runtime_error saying why not
void require_room(const std::filesystem::path& folder);

/// Its file system is so small (64 MiB) that filling it harms nobody who did not ask for it.
bool is_small_disk(const std::filesystem::path& folder);

/// Nothing more can be written there.
bool is_full(const std::filesystem::path& folder);

/// A file's bytes, "" if there is none.
std::string read_text(const std::filesystem::path& file);

/// Whole or not at all: what was there stays until the new file is complete. What is no file (a
/// pipe, a device) is written as it is. @throws std::runtime_error saying why it cannot be written
void write_text(const std::filesystem::path& file, const std::string& text);

/// The last `lines` lines of a file, "" if there is none.
std::string tail(const std::filesystem::path& file, int lines);

}  // namespace c3rt::cli
