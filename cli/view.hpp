#pragma once
// `c3rt view`: what happens on the bus, live in a browser.
#include <string>

#include "cli/python_program.hpp"

namespace c3rt::cli {

struct ViewSettings {
  ShownScenario shown;
  int port = 8080;
  std::string host = "127.0.0.1";
};

/// Becomes the page's program, the Python package's c3rt.view; it ends with Ctrl-C.
/// @throws UsageError where no scenario is known, or there is no Python with the package
int view(const Seat& seat, const ViewSettings& settings);

}  // namespace c3rt::cli
