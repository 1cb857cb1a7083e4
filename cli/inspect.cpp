#include "cli/inspect.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/inspect_mechanism.hpp"
#include "cli/inspect_report.hpp"
#include "cli/millimetres.hpp"
#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "controller/lcs/lcs.hpp"
#include "controller/mjcf/mechanism.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/model/objects_model.hpp"
#include "controller/model/support_points.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// what a scenario would say
constexpr double kEffectorMass = 1.0;       // [kg]
constexpr double kEffectorRadius = 0.0195;  // [m]
constexpr double kEffectorGap = 0.01;       // [m]
constexpr double kFrictionTable = 0.4, kFrictionEffector = 0.5, kFrictionObjects = 0.3;
constexpr double kApart = 0.05;  // objects from each other [m]

struct Inspected {
  std::vector<mjcf::ObjectFile> files;
  std::unique_ptr<model::PlanningModel> model;
  scene::Scene scene;
  std::vector<int> contacts;
  std::vector<std::string> warnings;
};

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

std::string name_of(const scene::Scene& scene, int body) {
  if (body == model::ContactPair::kEndEffector) return "end effector";
  if (body == model::ContactPair::kTable) return "table";
  return scene.body(body).name.c_str();
}

void print_pairs(Inspected& of, const model::ContactSystem& system) {
  fmt::print(
      "contacts, as the {} on the table, with the end effector at {:.4g} {:.4g} {:.4g} mm "
      "from the first one's centre of mass\n",
      of.files.size() == 1 ? "object lies" : "objects lie",
      (of.scene.effector.p_WE - of.scene.body(0).p_WB).x() / kMillimetre,
      (of.scene.effector.p_WE - of.scene.body(0).p_WB).y() / kMillimetre,
      (of.scene.effector.p_WE - of.scene.body(0).p_WB).z() / kMillimetre);
  const model::Layout& layout = of.model->layout();
  for (std::size_t i = 0; i < of.contacts.size(); ++i) {
    const model::ModelContact& contact = layout.contacts[static_cast<std::size_t>(of.contacts[i])];
    const auto row = static_cast<Eigen::Index>(i);
    // the normal is what J_n has in the columns of the first body's velocity
    const int first = contact.bodies.first == model::ContactPair::kEndEffector
                          ? model::ObjectsLayout::effector
                          : model::ObjectsLayout::position(contact.bodies.first);
    const Vector3d normal = system.J_n.row(row).segment<3>(first).transpose();
    const double gap = system.distance[row];
    fmt::print("  {} ({} and {}): gap {:.4g} mm, normal {:.3f} {:.3f} {:.3f}, friction {:.3g}\n",
               contact.pair, name_of(of.scene, contact.bodies.first),
               name_of(of.scene, contact.bodies.second), gap / kMillimetre, rounded(normal.x()),
               rounded(normal.y()), rounded(normal.z()), system.mu[row]);
    if (gap < -0.1 * kMillimetre) {
      of.warnings.push_back(fmt::format("{} and {} overlap by {:.3g} mm where it is inspected",
                                        name_of(of.scene, contact.bodies.first),
                                        name_of(of.scene, contact.bodies.second),
                                        -gap / kMillimetre));
    }
  }
}

void print_errors(Inspected& of, model::ContactModel contact_model, double step) {
  print_error_heading();
  const auto row = [&](const std::string& name, const scene::Scene& scene) {
    const model::BlockErrors errors =
        model::block_errors(*of.model, contact_model, scene, of.contacts, step);
    print_error_row(name, errors);
    return errors;
  };
  const model::BlockErrors resting = row("at rest", of.scene);
  scene::Scene moving = of.scene;
  for (int i = 0; i < moving.body_count; ++i) {
    moving.body(i).v_WB << kInspectedSpeed, 0.0, 0.0;
    moving.body(i).omega_WB << 0.0, 0.0, kInspectedTurn;
  }
  const model::BlockErrors turning =
      row(fmt::format("at {:g} m/s and {:g} rad/s", kInspectedSpeed, kInspectedTurn), moving);
  warn_of_errors(resting, turning, of.warnings);
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

/// Every object 0.1 m farther along x, by C3+.
std::string problem_of(const Inspected& of, const lcs::Lcs& lcs) {
  const model::Layout& layout = of.model->layout();
  VectorXd x0(layout.n_x), Q(layout.n_x);
  of.model->state(of.scene, x0);
  VectorXd wanted = x0;
  for (const model::StateBlock& block : layout.x) {
    Q.segment(block.start, block.size).setConstant(weight_of(block.name));
    if (block.name == "object_xy") wanted[block.start] += 0.1;
  }
  const VectorXd any = VectorXd::Constant(layout.n_u, std::numeric_limits<double>::infinity());
  return problem_file(lcs, x0, Q, wanted, -any, any);
}

/// What is said of a model with motors, and of no other.
void refuse_of_mechanism(const InspectSettings& settings) {
  for (const std::string& pair : settings.pairs) {
    if (pair.find(',') != std::string::npos)
      throw UsageError("--pairs: expected pairs of a model without motors, one of " +
                       fmt::format("{}", fmt::join(inspect_pairs(), ", ")) + ", got " + pair);
  }
  if (settings.directions || !settings.across.empty())
    throw UsageError("--directions and --across: expected a model with motors, got objects alone");
}

int inspect_objects(const InspectSettings& settings) {
  refuse_of_mechanism(settings);
  Inspected of;
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

  const auto contact_model = settings.contact_model == "stewart_trinkle"
                                 ? model::ContactModel::kStewartTrinkle
                                 : model::ContactModel::kAnitescu;
  const model::ContactSystem system = of.model->contact_system(of.scene, of.contacts);
  const lcs::Lcs lcs = model::to_lcs(contact_model, system, settings.step);
  fmt::print("bodies\n");
  for (const mjcf::ObjectFile& file : of.files) {
    print_object(file.object, of.warnings);
    for (const std::string& note : file.notes)
      of.warnings.push_back(file.object.name + ": " + note);
  }
  print_pairs(of, system);
  fmt::print(
      "sizes\n  n_x {}, n_u {}, n_lambda {}: {}, {} contacts with {} edges each, step {:g} s\n",
      layout.n_x, layout.n_u, lcs.F.rows(), settings.contact_model, of.contacts.size(), layout.n_e,
      settings.step);
  print_conditioning(lcs);
  print_errors(of, contact_model, settings.step);
  for (const mjcf::ObjectFile& file : of.files) {
    const int points = model::SupportPoints(file.object, settings.support_points).size();
    if (points < 3) {
      of.warnings.push_back(fmt::format(
          "{}: {} support point{}: nothing but its roundness resists a turn on the table",
          file.object.name, points, points == 1 ? "" : "s"));
    }
  }
  of.warnings.emplace_back(
      "a plan that believes its object larger than it is waits for contact that is not there: "
      "keep the model true or up to 3 % smaller (model.size_scale)");
  print_warnings(of.warnings);
  if (!settings.out.empty()) {
    write_text(settings.out, problem_of(of, lcs));
    fmt::print("written: {}: C3+ on this LCS, every object 0.1 m along x (c3rt solve {})\n",
               settings.out, settings.out);
  }
  return kDone;
}

}  // namespace

std::vector<std::string> inspect_pairs() {
  return {"end_effector_object", "object_table", "object_object"};
}

int inspect(const InspectSettings& settings) {
  try {
    for (const std::string& model : settings.models)
      if (mjcf::has_actuators(model)) return inspect_mechanism(settings);
  } catch (const mjcf::Error& e) {
    throw UsageError(e.what());
  }
  return inspect_objects(settings);
}

}  // namespace c3rt::cli
