#include "cli/soak/proc.hpp"

#include <fstream>
#include <sstream>
#include <system_error>

#include <unistd.h>

namespace c3rt::cli::soak {
namespace fs = std::filesystem;

invariants::ProcessSample look_at_process(const std::string& name, int pid, const fs::path& log) {
  invariants::ProcessSample sample;
  sample.name = name;
  const fs::path folder = fs::path("/proc") / std::to_string(pid);
  std::uint64_t size = 0, resident = 0;  // pages
  if (!(std::ifstream(folder / "statm") >> size >> resident) || size == 0) return sample;
  sample.memory = resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::ifstream status(folder / "status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("Threads:", 0) == 0) std::istringstream(line.substr(8)) >> sample.threads;
  }
  std::error_code error;
  for (fs::directory_iterator at(folder / "fd", error), end; !error && at != end;
       at.increment(error))
    ++sample.descriptors;
  const std::uintmax_t logged = log.empty() ? 0 : fs::file_size(log, error);
  sample.log = error ? 0 : logged;
  sample.pid = pid;
  return sample;
}

}  // namespace c3rt::cli::soak
