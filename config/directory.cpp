#include "config/directory.hpp"

#include "config/config_error.hpp"

namespace c3rt::config {
namespace fs = std::filesystem;

fs::path directory() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed =
      ((error ? fs::current_path() : program.parent_path()) / "../share/c3rt/config")
          .lexically_normal();
  const fs::path source = C3RT_CONFIG_SOURCE;
  for (const fs::path& candidate : {installed, source})
    if (fs::is_directory(candidate / "scenarios", error)) return fs::weakly_canonical(candidate);
  throw ConfigError("the scenarios are neither in " + installed.string() + " nor in " +
                    source.string());
}

bool is_path(const std::string& given, const std::string& extension) {
  return given.find('/') != std::string::npos || fs::path(given).extension() == extension;
}

}  // namespace c3rt::config
