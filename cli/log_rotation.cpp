#include "cli/log_rotation.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace c3rt::cli {
namespace fs = std::filesystem;
namespace {

fs::path older_log(const fs::path& log, int number) {
  return log.parent_path() /
         (log.stem().string() + "." + std::to_string(number) + log.extension().string());
}

bool is_older_log(const fs::path& log) {
  const std::string number = log.stem().extension().string();
  return number.size() > 1 && std::all_of(number.begin() + 1, number.end(),
                                          [](unsigned char c) { return std::isdigit(c) != 0; });
}

struct Descriptor {
  explicit Descriptor(int opened) : number(opened) {}
  ~Descriptor() {
    if (number >= 0) close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number;
};

/// All that is there, also what comes meanwhile. @return errno; 0: done
int copy(int from, int to) {
  std::array<char, 1 << 16> buffer;
  while (true) {
    const ssize_t count = read(from, buffer.data(), buffer.size());
    if (count == 0) return 0;
    if (count < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    for (ssize_t done = 0; done < count;) {
      const ssize_t written =
          write(to, buffer.data() + done, static_cast<std::size_t>(count - done));
      if (written >= 0) {
        done += written;
      } else if (errno != EINTR) {
        return errno;
      }
    }
  }
}

}  // namespace

std::string rotate_log(const fs::path& log, std::uintmax_t largest, int older) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(log, error);
  if (error || size <= largest) return "";
  const auto failed = [&log](const std::string& why) {
    return "cannot begin " + log.string() + " anew: " + why;
  };
  const Descriptor from(open(log.c_str(), O_RDWR | O_CLOEXEC));
  if (from.number < 0) return failed(std::strerror(errno));
  const fs::path part = log.string() + ".part";
  {
    const Descriptor to(open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    const int reason = to.number < 0 ? errno : copy(from.number, to.number);
    if (reason != 0) {
      fs::remove(part, error);
      return failed(std::strerror(reason));
    }
  }
  if (ftruncate(from.number, 0) != 0) {
    const int reason = errno;
    fs::remove(part, error);
    return failed(std::strerror(reason));
  }
  for (int number = older; number > 1; --number)
    fs::rename(older_log(log, number - 1), older_log(log, number), error);
  fs::rename(part, older_log(log, 1), error);
  return error ? failed(error.message()) : "";
}

std::string rotate_logs(const fs::path& folder, std::uintmax_t largest, int older) {
  std::error_code error;
  std::vector<fs::path> logs;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".log" && !is_older_log(entry.path()))
      logs.push_back(entry.path());
  }
  std::string reason;
  for (const fs::path& log : logs) {
    const std::string failed = rotate_log(log, largest, older);
    if (reason.empty()) reason = failed;
  }
  return reason;
}

}  // namespace c3rt::cli
