#pragma once
// The Python that runs what the programs hand over to the Python package of their sources or
// installation.
#include <string>
#include <vector>

namespace c3rt::cli {

struct FoundPython {
  std::string program;  // empty: there is none
  std::string missing;  // then what to install: "no Python with the package …"
};

/// A Python that has these packages: C3RT_PYTHON, that of the PATH, or Debian's. Nothing is
/// imported, which would take seconds.
FoundPython find_python(const std::vector<std::string>& packages);

/// A PYTHONPATH: the environment's, with the package c3rt of this program's sources or installation
/// first.
std::string package_path();

}  // namespace c3rt::cli
