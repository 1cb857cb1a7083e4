#include "cli/plan.hpp"

#include <array>
#include <istream>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/example/scenario.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "config/json_reader.hpp"
#include "config/scenario.hpp"
#include "controller/planner/planner.hpp"

namespace c3rt::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLatest = 1e9;            // [s]
constexpr double kUnitNorm = 1e-3;         // a quaternion's norm is 1 but for this
constexpr double kFarthest = 1e3;          // a position, a velocity, an angle
constexpr std::size_t kLongest = 1 << 16;  // a line

Eigen::Vector3d vector(config::JsonReader& reader, const char* key, bool optional = false) {
  if (optional && !reader.has(key)) return Eigen::Vector3d::Zero();
  Eigen::Vector3d value = reader.vector(key, 3);
  if (value.cwiseAbs().maxCoeff() <= kFarthest) return value;
  throw config::ConfigError(
      fmt::format("{}: expected numbers in [{:g}, {:g}], got ({:g}, {:g}, {:g})", reader.place(key),
                  -kFarthest, kFarthest, value.x(), value.y(), value.z()));
}

/// From the one or the other word.
Eigen::Quaterniond orientation(config::JsonReader& reader) {
  if (reader.has("yaw_rad") == reader.has("orientation_wxyz")) {
    throw config::ConfigError(reader.place("yaw_rad") +
                              ": expected this or orientation_wxyz, got both or none");
  }
  if (reader.has("yaw_rad")) {
    const double yaw = reader.number("yaw_rad", -kFarthest, kFarthest);
    return Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  }
  const Eigen::VectorXd q = reader.vector("orientation_wxyz", 4);
  if (std::abs(q.norm() - 1.0) > kUnitNorm) {
    throw config::ConfigError(fmt::format("{}: expected a norm of 1, got {:.6g}",
                                          reader.place("orientation_wxyz"), q.norm()));
  }
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

/// Of one line.
planner::Input read_scene(const nlohmann::json& json, const std::string& place, int bodies,
                          double after, double solve_time) {
  config::JsonReader scene(json, place, "");
  planner::Input input{};
  input.now = scene.number("time_s", 0.0, kLatest);
  if (input.now <= after) {
    throw config::ConfigError(fmt::format("{}: expected more than {:g}, the line before, got {:g}",
                                          scene.place("time_s"), after, input.now));
  }
  input.state_age = 0.0;
  input.solve_time = solve_time;
  input.robot_follows = scene.boolean("follows", true);
  config::JsonReader effector(scene.at("end_effector"), place, "end_effector");
  input.effector.p_WE = vector(effector, "position_m");
  input.effector.v_WE = vector(effector, "velocity_m_per_s", true);
  effector.finish();
  const nlohmann::json& objects = scene.at("objects");
  if (!objects.is_array() || objects.size() != static_cast<std::size_t>(bodies)) {
    throw config::ConfigError(fmt::format(
        "{}: expected a list of the scenario's {}, got {}", scene.place("objects"), bodies,
        objects.is_array() ? std::to_string(objects.size()) : std::string(objects.type_name())));
  }
  for (int i = 0; i < bodies; ++i) {
    const auto index = static_cast<std::size_t>(i);
    config::JsonReader object(objects[index], place, fmt::format("objects[{}]", i));
    planner::BodyInput& body = input.bodies[index];
    body.seen = true;
    body.age = 0.0;
    body.body.p_WB = vector(object, "position_m");
    body.body.q_WB = orientation(object);
    body.body.v_WB = vector(object, "velocity_m_per_s", true);
    body.body.omega_WB = vector(object, "angular_velocity_rad_per_s", true);
    object.finish();
  }
  scene.finish();
  return input;
}

Json list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

const char* name(planner::PlanStatus status) {
  switch (status) {
    case planner::PlanStatus::kOk:
      return "ok";
    case planner::PlanStatus::kTruncated:
      return "truncated";
    case planner::PlanStatus::kFallback:
      return "fallback";
  }
  return "";
}

}  // namespace

int plan(const std::string& scenario, const std::vector<std::string>& overrides, std::istream& in,
         std::ostream& out) {
  const std::filesystem::path file = scenario_path(scenario);
  if (is_example(file))
    throw UsageError("expected a scenario with a planner, got " + scenario +
                     ", which is a numerical example");
  const config::Scenario read = config::load_scenario(file.string(), overrides);
  const planner::Parameters& parameters = read.planner;
  planner::Planner planner(parameters);
  const int bodies = parameters.model.bodies;
  double last = -1.0;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty()) continue;
    const std::string place = fmt::format("line {}", number);
    if (line.size() > kLongest)
      throw UsageError(fmt::format("{}: expected at most {} characters", place, kLongest));
    const planner::Input input =
        read_scene(config::parse_json(line, place), place, bodies, last, read.timing.solve_time_s);
    last = input.now;
    const planner::Plan& plan = planner.step(input);
    const Eigen::Quaterniond& q = plan.q_WE;
    const Json answer{{"time_s", input.now},
                      {"phase", plan.phase},
                      {"status", name(plan.status)},
                      {"position_m", list(plan.p_WE)},
                      {"velocity_m_per_s", list(plan.v_WE)},
                      {"orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                      {"force_n", list(plan.force_E)},
                      {"says", planner::describe(planner.activity(), parameters, input.now)}};
    out << answer.dump() << std::endl;  // whoever asked waits for it
    if (!out) throw std::runtime_error("cannot write the plan to standard output");
  }
  return kDone;
}

}  // namespace c3rt::cli
