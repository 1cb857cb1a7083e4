#pragma once
// Programs of the Python package that go on where a command of c3rt ends: c3rt.view, c3rt.ros.
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/client.hpp"

namespace c3rt::cli {

/// Whose objects are shown.
struct ShownScenario {
  std::string scenario;  // empty: that of the instance on the domain
  std::vector<std::string> overrides;
};

/// What such a program draws and no topic tells: the objects' shapes, tip, table and arm, the
/// cameras, and of what they are made: the scenario's file, what overrides it, the seed.
/// @throws UsageError where none is named and none runs, config::ConfigError
nlohmann::ordered_json shown_scene(const Seat& seat, const ShownScenario& shown);

/// Becomes `python -m MODULE SCENE.json --domain D --profile P ARGUMENTS`; it ends with Ctrl-C.
/// @param extra of the package's extras the one that brings what it needs: "view"
/// @param packages that it needs besides c3rt
/// @throws UsageError where there is no Python with them
[[noreturn]] void become_python(const Seat& seat, const std::string& module,
                                const std::string& extra, const std::vector<std::string>& packages,
                                const nlohmann::ordered_json& scene,
                                const std::vector<std::string>& arguments);

}  // namespace c3rt::cli
