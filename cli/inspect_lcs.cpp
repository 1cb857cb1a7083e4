#include "cli/inspect_lcs.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/inspect_report.hpp"
#include "cli/paths.hpp"
#include "config/text.hpp"
#include "controller/mjcf/mechanism.hpp"
#include "controller/model/objects_model.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Kind = scene::Coordinate::Kind;

// what a scenario would say
constexpr double kEffectorMass = 1.0;       // [kg]
constexpr double kEffectorRadius = 0.0195;  // [m]
constexpr double kEffectorGap = 0.01;       // [m]
constexpr double kFrictionTable = 0.4, kFrictionEffector = 0.5, kFrictionObjects = 0.3;
constexpr double kApart = 0.05;  // objects from each other [m]

model::ContactModel contact_model_of(const InspectSettings& settings) {
  if (settings.contact_model == "anitescu") return model::ContactModel::kAnitescu;
  if (settings.contact_model == "stewart_trinkle") return model::ContactModel::kStewartTrinkle;
  throw UsageError("--contact-model: expected anitescu or stewart_trinkle, got \"" +
                   config::printable(settings.contact_model) + "\"");
}

/// The objects lying side by side on a table at height 0, the end effector beside the first.
scene::Scene lying(const model::PlanningModel& model, const std::vector<mjcf::ObjectFile>& files,
                   const std::vector<double>& effector) {
  scene::Scene scene = model.layout().world;
  double y = 0.0;
  for (int i = 0; i < scene.body_count; ++i) {
    const scene::Shape shape = files[static_cast<std::size_t>(i)].object.shape();
    if (i > 0) y += kApart + scene::reach(shape, -Vector3d::UnitY());
    scene.body(i).p_WB << 0.5, y, scene::reach(shape, -Vector3d::UnitZ());
    y += scene::reach(shape, Vector3d::UnitY());
  }
  const scene::Body& first = scene.body(0);
  if (effector.size() == 3) {
    scene.effector.p_WE = first.p_WB + Vector3d(effector[0], effector[1], effector[2]);
    return scene;
  }
  // from behind along x, no step longer than the gap allows
  scene.effector.p_WE = first.p_WB;
  scene.effector.p_WE.x() -= scene::reach(first.shape, -Vector3d::UnitX()) + 0.1;
  for (int step = 0; step < 100; ++step)
    scene.effector.p_WE.x() += scene::gap(scene.effector, first).distance - kEffectorGap;
  return scene;
}

/// What push tasks weigh, by block (docs/objects.md).
double weight_of(const std::string& block) {
  if (block == "object_xy") return 1.0;
  if (block == "object_rotation") return 0.05;
  if (block == "end_effector_z") return 10.0;
  if (block == "end_effector_velocity") return 0.02;
  if (block == "object_angular_velocity") return 1e-5;
  return block == "object_z" ? 0.0 : 1e-4;
}

/// What is said of a model with motors, and of no other.
void refuse_of_mechanism(const InspectSettings& settings) {
  for (const std::string& pair : settings.pairs) {
    const std::vector<std::string> known = inspect_pairs();
    if (std::find(known.begin(), known.end(), pair) == known.end())
      throw UsageError("--pairs: expected pairs of a model without motors, one of " +
                       fmt::format("{}", fmt::join(inspect_pairs(), ", ")) + ", got " +
                       config::printable(pair));
  }
  if (settings.directions || !settings.across.empty())
    throw UsageError("--directions and --across: expected a model with motors, got objects alone");
}

[[noreturn]] void refuse_pair(const std::string& pair) {
  throw UsageError("--pairs: expected FIRST,SECOND[,closest=N][,friction=MU], got \"" +
                   config::printable(pair) + "\"");
}

template <typename T>
T number(const std::string& text, const std::string& pair) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || value < T{}) refuse_pair(pair);
  return value;
}

model::Between between_of(const std::string& pair) {
  std::vector<std::string> words;
  for (std::size_t from = 0; from <= pair.size();) {
    const std::size_t comma = std::min(pair.find(',', from), pair.size());
    words.push_back(pair.substr(from, comma - from));
    from = comma + 1;
  }
  if (words.size() < 2 || words[0].empty() || words[1].empty()) refuse_pair(pair);
  model::Between between{words[0], words[1]};
  for (std::size_t i = 2; i < words.size(); ++i) {
    const std::size_t equals = words[i].find('=');
    const std::string key = words[i].substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : words[i].substr(equals + 1);
    if (key == "closest") {
      between.closest = number<int>(value, pair);
    } else if (key == "friction") {
      between.friction = number<double>(value, pair);
    } else {
      refuse_pair(pair);
    }
  }
  return between;
}

/// Every two bodies that no joint joins, where they are nearest, and each with all planes.
std::vector<model::Between> all_pairs(const scene::Mechanism& mechanism) {
  const std::vector<scene::RigidBody>& bodies = mechanism.bodies();
  std::vector<model::Between> result;
  const auto touches = [](const scene::RigidBody& of) { return !of.object.parts->parts.empty(); };
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    if (!touches(bodies[i])) continue;
    for (const scene::Surface& surface : mechanism.surfaces()) {
      if (surface.body == 0)
        result.push_back({bodies[i].object.name, surface.name, surface.is_plane ? 0 : 1});
    }
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      const bool joined =
          bodies[j].parent == static_cast<int>(i) || bodies[i].parent == static_cast<int>(j);
      if (touches(bodies[j]) && !joined)
        result.push_back({bodies[i].object.name, bodies[j].object.name, 1});
    }
  }
  return result;
}

/// What no motor moves is brought somewhere: all free bodies along x, else the first joint of those
/// without a motor, else the first.
void set_goal(const scene::Mechanism& mechanism, SeenMechanism& seen) {
  const int n_v = mechanism.n_v();
  seen.x0.setZero(2 * n_v);
  seen.Q.setZero(2 * n_v);
  seen.x0.head(n_v) = mechanism.home();
  seen.x_desired = seen.x0;
  int joint = -1;
  for (int i = 0; i < n_v; ++i) {
    const scene::Coordinate& of = mechanism.coordinates()[static_cast<std::size_t>(i)];
    const bool driven = mechanism.bodies()[static_cast<std::size_t>(of.body)].driven;
    const char axis = of.name.back();
    double &of_q = seen.Q[i], &of_v = seen.Q[n_v + i];
    if (of.kind == Kind::kPosition) {
      of_q = axis == 'z' ? 0.0 : 1.0;
      of_v = 1e-4;
      if (axis == 'x') {
        seen.x_desired[i] += kInspectedGoal;
        seen.goal += (seen.goal.empty() ? "" : ", ") + of.name;
      }
    } else if (of.kind == Kind::kRotation) {
      of_q = 0.05;
      of_v = 1e-5;
    } else {
      of_q = driven ? 1e-4 : 1.0;
      of_v = driven ? 0.02 : 1e-4;
      if (joint < 0 ||
          (!driven && mechanism
                          .bodies()[static_cast<std::size_t>(
                              mechanism.coordinates()[static_cast<std::size_t>(joint)].body)]
                          .driven))
        joint = i;
    }
  }
  if (seen.goal.empty() && joint >= 0) {
    seen.Q[joint] = 1.0;
    seen.x_desired[joint] += kInspectedGoal;
    seen.goal = mechanism.coordinates()[static_cast<std::size_t>(joint)].name;
  }
}

/// Every object is to lie farther along x.
void set_goal(SeenObjects& seen) {
  const model::Layout& layout = seen.model->layout();
  seen.x0.resize(layout.n_x);
  seen.Q.resize(layout.n_x);
  seen.names.resize(static_cast<std::size_t>(layout.n_x));
  seen.model->state(seen.scene, seen.x0);
  seen.x_desired = seen.x0;
  for (const model::StateBlock& block : layout.x) {
    seen.Q.segment(block.start, block.size).setConstant(weight_of(block.name));
    std::fill_n(seen.names.begin() + block.start, block.size, block.name);
    if (block.name == "object_xy") seen.x_desired[block.start] += kInspectedGoal;
  }
  seen.u_max.setConstant(layout.n_u, std::numeric_limits<double>::infinity());
  seen.u_min = -seen.u_max;
}

}  // namespace

std::vector<std::string> inspect_pairs() {
  return {"end_effector_object", "object_table", "object_object"};
}

bool has_motors(const InspectSettings& settings) {
  try {
    return std::any_of(settings.models.begin(), settings.models.end(), mjcf::has_actuators);
  } catch (const mjcf::Error& e) {
    throw UsageError(e.what());
  }
}

SeenObjects see_objects(const InspectSettings& settings) {
  refuse_of_mechanism(settings);
  SeenObjects of;
  of.contact_model = contact_model_of(settings);
  model::ObjectsParameters parameters{kEffectorMass,           kEffectorRadius, 0.0,
                                      kFrictionEffector,       kFrictionTable,  kFrictionObjects,
                                      settings.support_points, false,           {}};
  try {
    for (const std::string& model : settings.models) {
      of.files.push_back(mjcf::read_object(model));
      parameters.objects.push_back(of.files.back().object);
    }
    of.model = model::make_objects_model(parameters);
  } catch (const mjcf::Error& e) {
    throw UsageError(e.what());
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
  of.scene = lying(*of.model, of.files, settings.effector);
  const model::Layout& layout = of.model->layout();
  for (int i = 0; i < layout.n_c(); ++i) {
    const std::string& pair = layout.contacts[static_cast<std::size_t>(i)].pair;
    const std::vector<std::string>& wanted = settings.pairs;
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), pair) != wanted.end())
      of.contacts.push_back(i);
  }
  if (of.contacts.empty())
    throw UsageError("--pairs: expected contacts that the model has, got " + settings.pairs[0] +
                     " of one object alone");
  of.system = of.model->contact_system(of.scene, of.contacts);
  of.lcs = model::to_lcs(of.contact_model, of.system, settings.step);
  set_goal(of);
  return of;
}

SeenMechanism see_mechanism(const InspectSettings& settings) {
  if (settings.models.size() != 1)
    throw UsageError("lcs inspect: expected one file where it has motors, got " +
                     std::to_string(settings.models.size()));
  if (!settings.effector.empty())
    throw UsageError("--effector: expected objects alone, got a model with motors of its own");
  SeenMechanism of;
  try {
    mjcf::MechanismFile file = mjcf::read_mechanism(settings.models[0]);
    of.notes = std::move(file.notes);
    model::MechanismParameters parameters;
    for (const std::string& pair : settings.pairs) parameters.contacts.push_back(between_of(pair));
    if (settings.pairs.empty()) parameters.contacts = all_pairs(*file.mechanism);
    parameters.mechanism = std::move(file.mechanism);
    parameters.contact_model = contact_model_of(settings);
    parameters.directions = settings.directions.value_or(parameters.directions);
    parameters.support_points = settings.support_points;
    if (!settings.across.empty())
      parameters.across = Vector3d(settings.across[0], settings.across[1], settings.across[2]);
    of.model = std::make_unique<model::MechanismModel>(parameters);
  } catch (const mjcf::Error& e) {
    throw UsageError(e.what());
  } catch (const std::invalid_argument& e) {
    throw UsageError(settings.models[0] + ": " + e.what());
  }
  const scene::Mechanism& mechanism = of.model->mechanism();
  set_goal(mechanism, of);
  of.model->evaluate(of.x0, of.system);
  of.lcs = model::to_lcs(of.model->contact_model(), of.system, settings.step);
  for (const model::Quantity& quantity : of.model->layout().x) of.names.push_back(quantity.name);
  of.u_min.resize(of.lcs.B.cols());
  of.u_max.resize(of.lcs.B.cols());
  for (Eigen::Index i = 0; i < of.u_min.size(); ++i) {
    of.u_min[i] = mechanism.motors()[static_cast<std::size_t>(i)].min;
    of.u_max[i] = mechanism.motors()[static_cast<std::size_t>(i)].max;
  }
  return of;
}

std::string problem_file(const Seen& of) {
  return problem_file(of.lcs, of.x0, of.Q, of.x_desired, of.u_min, of.u_max);
}

}  // namespace c3rt::cli
