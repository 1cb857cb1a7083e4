#include "cli/python.hpp"

#include <cstdlib>

#include <fmt/format.h>

#include "cli/program.hpp"
#include "config/directory.hpp"

namespace c3rt::cli {
namespace {

constexpr double kLook = 20.0;  // from a cold disk [s]

}  // namespace

FoundPython find_python(const std::vector<std::string>& packages) {
  const char* chosen = std::getenv("C3RT_PYTHON");
  std::vector<std::string> candidates{"python3", "/usr/bin/python3"};
  if (chosen != nullptr) candidates = {chosen};
  std::string looks = "from importlib.util import find_spec\n";
  for (const std::string& package : packages)
    looks += fmt::format("assert find_spec('{}') is not None\n", package);
  for (std::string& candidate : candidates) {
    const ProgramEnd end = run_program({candidate, "-c", looks}, "", kLook);
    if (end.ok()) return {candidate, ""};
    if (end.kind == ProgramEnd::Kind::kTimedOut) candidate += ", which " + end.reason;
  }
  const std::string what =
      packages.empty() ? "" : fmt::format(" with the package {}", fmt::join(packages, " and "));
  const std::string how =
      packages.empty() ? "Debian: python3"
                       : fmt::format("Debian: python3-{}; pip: {}",
                                     fmt::join(packages, " python3-"), fmt::join(packages, " "));
  return {"", fmt::format("no Python{} (looked at: {}); install it ({}) or name a Python that has "
                          "it in C3RT_PYTHON",
                          what, fmt::join(candidates, ", "), how)};
}

std::string package_path() {
  // beside the scenarios, in the sources and where it is installed
  const std::string ours = (config::directory().parent_path() / "python").string();
  const char* others = std::getenv("PYTHONPATH");
  return others != nullptr && *others != '\0' ? ours + ":" + others : ours;
}

}  // namespace c3rt::cli
