#include "cli/campaign/python.hpp"

#include <cstdlib>
#include <vector>

#include "cli/paths.hpp"
#include "cli/program.hpp"

namespace c3rt::cli::campaign {
namespace fs = std::filesystem;
namespace {

constexpr double kImport = 60.0;  // of a package, from a cold disk [s]

}  // namespace

std::string python_with(const std::string& wanted, const std::string& module,
                        const std::string& package) {
  const char* chosen = std::getenv("C3RT_PYTHON");
  std::vector<std::string> candidates{"python3", "/usr/bin/python3"};
  if (chosen != nullptr) candidates = {chosen};
  for (const std::string& candidate : candidates) {
    if (run_program({candidate, "-c", "import " + module}, "", kImport).ok()) return candidate;
  }
  std::string names;
  for (const std::string& candidate : candidates) names += (names.empty() ? "" : ", ") + candidate;
  throw UsageError(wanted + ": no Python with the package " + package + " (looked at: " + names +
                   "); install it (Debian: python3-" + package + "; pip: " + package +
                   ") or name a Python that has it in C3RT_PYTHON");
}

fs::path python_file(const std::string& folder, const std::string& name) {
  const fs::path here = binary_directory();
  for (const fs::path& candidate :
       {here / "../share/c3rt" / name, here / "../../../cli" / folder / name}) {
    if (fs::is_regular_file(candidate)) return fs::weakly_canonical(candidate);
  }
  throw UsageError(name + " is not beside this program's other files");
}

}  // namespace c3rt::cli::campaign
