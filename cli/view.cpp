#include "cli/view.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "cli/lock.hpp"
#include "cli/matrix_json.hpp"
#include "cli/paths.hpp"
#include "cli/program.hpp"

namespace c3rt::cli {
namespace {

using nlohmann::ordered_json;

constexpr double kLookTime = 60.0;  // [s]
// the package's own import takes seconds
constexpr const char* kLook =
    "import importlib.util, sys\n"
    "for name in ('c3rt', 'c3rt.view', 'viser', 'cyclonedds'):\n"
    "  if importlib.util.find_spec(name) is None:\n"
    "    print('the package ' + name, end='')\n"
    "    sys.exit(1)\n";

ordered_json list_of(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

ordered_json json_of(const scene::Shape& shape) {
  switch (shape.kind) {
    case scene::ShapeKind::kSphere:
      return {{"kind", "sphere"}, {"radius", shape.radius}};
    case scene::ShapeKind::kBox:
      return {{"kind", "box"}, {"half_sizes", list_of(shape.half_sizes)}};
    case scene::ShapeKind::kCapsule:
      return {{"kind", "capsule"}, {"radius", shape.radius}, {"half_length", shape.half_length}};
    case scene::ShapeKind::kCylinder:
      return {{"kind", "cylinder"}, {"radius", shape.radius}, {"half_length", shape.half_length}};
    case scene::ShapeKind::kConvexMesh: {
      ordered_json vertices = ordered_json::array();
      for (const Eigen::Vector3d& vertex : shape.mesh->vertices())
        vertices.push_back(list_of(vertex));
      return {{"kind", "convex_mesh"}, {"vertices", vertices}};
    }
    case scene::ShapeKind::kUnion: {
      ordered_json parts = ordered_json::array();
      for (const scene::Part& part : shape.parts->parts) {
        parts.push_back({{"shape", json_of(part.shape)},
                         {"p_BP", list_of(part.p_BP)},
                         {"R_BP", rows_of<ordered_json>(part.R_BP)}});
      }
      return {{"kind", "union"}, {"parts", parts}};
    }
  }
  return {};
}

config::Scenario scenario_of(const Seat& seat, const ViewSettings& settings) {
  if (!settings.scenario.empty())
    return config::load_scenario(scenario_path(settings.scenario).string(), settings.overrides);
  const auto instance = holder(runtime_directory(), seat.domain);
  if (!instance) {
    throw UsageError(fmt::format(
        "no instance of yours runs on domain {}: of another host name its scenario, --scenario "
        "circle_slow",
        seat.domain));
  }
  return config::load_scenario(instance->file, instance->overrides);
}

/// The file is gone once the page's program has read it.
std::string write_scene(const ordered_json& scene) {
  std::string name = (runtime_directory() / "view-XXXXXX").string();
  const int file = mkstemp(name.data());
  const std::string text = scene.dump();
  if (file < 0 || write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
    throw UsageError("cannot write " + name + ": " + std::strerror(errno));
  close(file);
  return name;
}

}  // namespace

ordered_json view_scene(const config::Scenario& scenario) {
  ordered_json objects = ordered_json::array();
  for (const plant::ObjectParameters& object : scenario.plant.world.objects)
    objects.push_back({{"name", object.object.name}, {"shape", json_of(object.object.shape())}});
  return {{"scenario", scenario.name},
          {"objects", objects},
          {"tip_radius_m", scenario.plant.world.end_effector.sphere_radius},
          {"table_height_m", scenario.plant.world.table_height},
          {"urdf", scenario.impedance.arm.urdf_path}};
}

int view(const Seat& seat, const ViewSettings& settings) {
  const char* chosen = std::getenv("C3RT_PYTHON");
  const std::string python = chosen != nullptr ? chosen : "python3";
  const ordered_json scene = view_scene(scenario_of(seat, settings));
  const ProgramEnd found = run_program({python, "-c", kLook}, "", kLookTime);
  if (!found.ok()) {
    throw UsageError(fmt::format(
        "{} has not {}: pip install './python[view]', or name another Python with C3RT_PYTHON",
        python, found.output.empty() ? "the package c3rt: " + found.reason : found.output));
  }
  const auto instance = holder(runtime_directory(), seat.domain);
  const std::string profile = instance && !instance->profile.empty()
                                  ? instance->profile
                                  : dds_profile_path(seat.dds_profile).string();
  const std::string file = write_scene(scene);
  const std::string domain = std::to_string(seat.domain), port = std::to_string(settings.port);
  execlp(python.c_str(), python.c_str(), "-m", "c3rt.view", file.c_str(), "--domain",
         domain.c_str(), "--profile", profile.c_str(), "--host", settings.host.c_str(), "--port",
         port.c_str(), static_cast<char*>(nullptr));
  throw UsageError(python + ": " + std::strerror(errno));
}

}  // namespace c3rt::cli
