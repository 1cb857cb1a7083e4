#pragma once
// `c3rt view`: what happens on the bus, live in a browser.
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/client.hpp"
#include "config/scenario.hpp"

namespace c3rt::cli {

struct ViewSettings {
  std::string scenario;  // empty: that of the instance on the domain
  std::vector<std::string> overrides;
  int port = 8080;
  std::string host = "127.0.0.1";
};

/// What the page draws and no topic tells: the objects' shapes, tip, table and arm.
nlohmann::ordered_json view_scene(const config::Scenario& scenario);

/// Becomes the page's program, the Python package's c3rt.view; it ends with Ctrl-C.
/// @throws UsageError where no scenario is known, or there is no Python with the package
int view(const Seat& seat, const ViewSettings& settings);

}  // namespace c3rt::cli
