#include "cli/paths.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <deque>
#include <fstream>
#include <sstream>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "config/directory.hpp"

namespace c3rt::cli {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kRoom = std::size_t{256} * 1024;             // at the start [bytes]
constexpr std::size_t kSmallDisk = std::size_t{64} * 1024 * 1024;  // [bytes]
constexpr std::size_t kLeast = std::size_t{16} * 1024;  // below this a log loses lines [bytes]

std::vector<std::string> names_in(const fs::path& directory, const std::string& extension) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (entry.path().extension() == extension) names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

/// A file from its path or, in `folder` of the configuration, from its name.
fs::path find(const std::string& what, const std::string& given, const std::string& folder,
              const std::string& extension) {
  if (config::is_path(given, extension)) {
    if (!fs::is_regular_file(given)) throw UsageError(what + " \"" + given + "\": no such file");
    return fs::absolute(given);
  }
  const fs::path directory = config::directory() / folder;
  fs::path file = directory / (given + extension);
  if (given.empty() || !fs::is_regular_file(file)) {
    throw UsageError("unknown " + what + " \"" + given +
                     "\"; known: " + joined(names_in(directory, extension)) + " (or a path to a " +
                     extension + " file)");
  }
  return file;
}

}  // namespace

fs::path binary_directory() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::current_path() : self.parent_path();
}

fs::path process_directory() {
  const char* chosen = std::getenv("C3RT_PROCESS_DIRECTORY");
  return chosen != nullptr ? fs::path(chosen) : binary_directory();
}

std::vector<std::string> scenario_names() {
  return names_in(config::directory() / "scenarios", ".yaml");
}

fs::path scenario_path(const std::string& scenario) {
  return find("scenario", scenario, "scenarios", ".yaml");
}

fs::path dds_profile_path(const std::string& profile) {
  return find("DDS profile", profile, "dds", ".xml");
}

fs::path runtime_directory() {
  const char* session = std::getenv("XDG_RUNTIME_DIR");
  fs::path directory = session != nullptr && access(session, W_OK) == 0
                           ? fs::path(session) / "c3rt"
                           : fs::temp_directory_path() / ("c3rt-" + std::to_string(getuid()));
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw UsageError("cannot make " + directory.string() + ": " + error.message());
  return directory;
}

fs::path supervisor_log(unsigned domain) {
  return runtime_directory() / ("supervisor-" + std::to_string(domain) + ".log");
}

fs::path new_folder(const std::string& name) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  char date[32];
  std::strftime(date, sizeof date, "%Y%m%d-%H%M%S", localtime_r(&now, &local));
  const std::string dated = name + "-" + date;
  fs::path folder = fs::path("out") / dated;
  for (int i = 2; fs::exists(folder); ++i)
    folder = fs::path("out") / (dated + "-" + std::to_string(i));
  return folder;
}

fs::path make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw UsageError("cannot make " + folder.string() + ": " + error.message());
  return fs::absolute(folder);
}

void require_room(const fs::path& folder) {
  // a quota or a reserve shows only when something is written
  const fs::path probe = folder / (".c3rt-" + std::to_string(getpid()) + ".room");
  std::string reason;
  try {
    write_text(probe, std::string(kRoom, ' '));
  } catch (const std::runtime_error& error) {
    reason = error.what();
    reason = reason.substr(reason.rfind(": ") + 2);
  }
  std::error_code error;
  fs::remove(probe, error);
  if (!reason.empty())
    throw std::runtime_error("no room for logs and results in " + folder.string() + ": " + reason);
}

bool is_small_disk(const fs::path& folder) {
  struct statvfs room {};
  return statvfs(folder.c_str(), &room) == 0 && room.f_blocks * room.f_frsize <= kSmallDisk;
}

bool is_full(const fs::path& folder) {
  struct statvfs room {};
  return statvfs(folder.c_str(), &room) == 0 && room.f_bavail * room.f_frsize < kLeast;
}

std::string read_text(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void write_text(const fs::path& file, const std::string& text) {
  const auto fail = [&](int error) {
    throw std::runtime_error("cannot write " + file.string() + ": " + std::strerror(error));
  };
  // a link stays one
  fs::path target = file;
  std::error_code no_link;
  for (int links = 0; links < 40 && fs::is_symlink(target, no_link); ++links)
    target = target.parent_path() / fs::read_symlink(target, no_link);
  struct stat existing {};
  const bool exists = stat(target.c_str(), &existing) == 0;
  if (exists && access(target.c_str(), W_OK) != 0) fail(errno);
  const bool in_place = exists && !S_ISREG(existing.st_mode);
  static std::atomic<int> number{0};
  const std::string part_name =
      ".c3rt-" + std::to_string(getpid()) + "-" + std::to_string(++number) + ".part";
  const fs::path part = in_place ? target : target.parent_path() / part_name;
  const int descriptor =
      open(part.c_str(), O_WRONLY | O_CLOEXEC | (in_place ? 0 : O_CREAT | O_TRUNC), 0666);
  if (descriptor < 0) fail(errno);
  int error = 0;
  for (std::size_t done = 0; done < text.size() && error == 0;) {
    const ssize_t count = write(descriptor, text.data() + done, text.size() - done);
    if (count >= 0) {
      done += static_cast<std::size_t>(count);
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (!in_place && exists && error == 0 && fchmod(descriptor, existing.st_mode & 07777) != 0)
    error = errno;
  if (!in_place && error == 0 && fsync(descriptor) != 0) error = errno;
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (!in_place && error == 0 && rename(part.c_str(), target.c_str()) != 0) error = errno;
  if (error == 0) return;
  if (!in_place) unlink(part.c_str());
  fail(error);
}

std::string tail(const fs::path& file, int lines) {
  std::ifstream stream(file);
  std::deque<std::string> kept;
  for (std::string line; std::getline(stream, line);) {
    kept.push_back(line);
    if (kept.size() > static_cast<std::size_t>(lines)) kept.pop_front();
  }
  std::string text;
  for (const std::string& line : kept) text += line + "\n";
  return text;
}

}  // namespace c3rt::cli
