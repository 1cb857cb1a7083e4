#include "cli/python_program.hpp"

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
#include "config/scenario.hpp"
#include "controller/planner/adjustable_weights.hpp"

namespace c3rt::cli {
namespace {

using nlohmann::ordered_json;

constexpr double kLookTime = 60.0;  // [s]
/// What asks Python for packages: the package's own import takes seconds.
std::string looks_for(const std::string& module, const std::vector<std::string>& packages) {
  std::string names = "'c3rt', '" + module + "'";
  for (const std::string& package : packages) names += ", '" + package + "'";
  return "import importlib.util, sys\n"
         "for name in (" +
         names +
         "):\n"
         "  if importlib.util.find_spec(name) is None:\n"
         "    print('the package ' + name, end='')\n"
         "    sys.exit(1)\n";
}

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

/// The file is gone once the page's program has read it.
std::string write_scene(const ordered_json& scene) {
  std::string name = (runtime_directory() / "scene-XXXXXX").string();
  const int file = mkstemp(name.data());
  const std::string text = scene.dump();
  if (file < 0 || write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
    throw UsageError("cannot write " + name + ": " + std::strerror(errno));
  close(file);
  return name;
}

}  // namespace

ordered_json shown_scene(const Seat& seat, const ShownScenario& shown) {
  std::string file;
  std::vector<std::string> overrides = shown.overrides;
  std::uint64_t seed = 1;
  if (!shown.scenario.empty()) {
    file = scenario_path(shown.scenario).string();
  } else {
    const auto instance = holder(runtime_directory(), seat.domain);
    if (!instance || instance->file.empty()) {
      throw UsageError(fmt::format(
          "no instance of yours on domain {} tells its scenario: name it, as that of another "
          "host, --scenario circle_slow",
          seat.domain));
    }
    file = instance->file;
    overrides = instance->overrides;
    seed = instance->seed;
  }
  const config::Scenario scenario = config::load_scenario(file, overrides);
  ordered_json objects = ordered_json::array(), cameras = ordered_json::array(),
               weights = ordered_json::array();
  for (const plant::ObjectParameters& object : scenario.plant.world.objects)
    objects.push_back({{"name", object.object.name}, {"shape", json_of(object.object.shape())}});
  if (scenario.vision.source == vision::SourceKind::kCameras) {
    for (const vision::CameraParameters& camera : scenario.vision.cameras) {
      cameras.push_back(
          {{"name", camera.name}, {"width_px", camera.width}, {"height_px", camera.height}});
    }
  }
  for (const planner::AdjustableWeight& weight : planner::adjustable_weights(scenario.planner)) {
    weights.push_back(
        {{"name", weight.name}, {"value", weight.value}, {"min", weight.min}, {"max", weight.max}});
  }
  return {{"scenario", scenario.name},
          {"weights", weights},
          {"file", file},
          {"overrides", overrides},
          {"seed", seed},
          {"objects", objects},
          {"cameras", cameras},
          {"tip_radius_m", scenario.plant.world.end_effector.sphere_radius},
          {"table_height_m", scenario.plant.world.table_height},
          {"urdf", scenario.impedance.arm.urdf_path}};
}

void become_python(const Seat& seat, const std::string& module, const std::string& extra,
                   const std::vector<std::string>& packages, const ordered_json& scene,
                   const std::vector<std::string>& arguments) {
  const char* chosen = std::getenv("C3RT_PYTHON");
  const std::string python = chosen != nullptr ? chosen : "python3";
  const ProgramEnd found = run_program({python, "-c", looks_for(module, packages)}, "", kLookTime);
  if (!found.ok()) {
    throw UsageError(fmt::format(
        "{} has not {}: pip install './python[{}]', or name another Python with C3RT_PYTHON",
        python, found.output.empty() ? "the package c3rt: " + found.reason : found.output, extra));
  }
  const auto instance = holder(runtime_directory(), seat.domain);
  const std::string profile = instance && !instance->profile.empty()
                                  ? instance->profile
                                  : dds_profile_path(seat.dds_profile).string();
  std::vector<std::string> words{
      python,      "-m",   module, write_scene(scene), "--domain", std::to_string(seat.domain),
      "--profile", profile};
  words.insert(words.end(), arguments.begin(), arguments.end());
  become_program(words);
}

}  // namespace c3rt::cli
