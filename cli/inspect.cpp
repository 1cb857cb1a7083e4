#include "cli/inspect.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/millimetres.hpp"
#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "controller/lcs/lcs.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/model/objects_model.hpp"
#include "controller/model/support_points.hpp"
#include "controller/scene/distance.hpp"

namespace c3rt::cli {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// what a scenario would say
constexpr double kEffectorMass = 1.0;       // [kg]
constexpr double kEffectorRadius = 0.0195;  // [m]
constexpr double kEffectorGap = 0.01;       // [m]
constexpr double kFrictionTable = 0.4, kFrictionEffector = 0.5, kFrictionObjects = 0.3;
constexpr double kApart = 0.05;              // objects from each other [m]
constexpr double kSpeed = 0.1, kTurn = 1.0;  // of the moving object [m/s], [rad/s]

struct Inspected {
  std::vector<mjcf::ObjectFile> files;
  std::unique_ptr<model::PlanningModel> model;
  scene::Scene scene;
  std::vector<int> contacts;
  std::vector<std::string> warnings;
};

double extent(const scene::Object& object, const Vector3d& along) {
  return scene::reach(object.shape(), along) + scene::reach(object.shape(), -along);
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

std::string describe(const scene::Shape& shape) {
  const auto mm = [](double length) { return length / kMillimetre; };
  switch (shape.kind) {
    case scene::ShapeKind::kSphere:
      return fmt::format("sphere of radius {:.4g} mm", mm(shape.radius));
    case scene::ShapeKind::kBox:
      return fmt::format("box of {:.4g} x {:.4g} x {:.4g} mm", mm(2 * shape.half_sizes.x()),
                         mm(2 * shape.half_sizes.y()), mm(2 * shape.half_sizes.z()));
    case scene::ShapeKind::kCapsule:
    case scene::ShapeKind::kCylinder:
      return fmt::format("{} of radius {:.4g} mm and {} {:.4g} mm",
                         shape.kind == scene::ShapeKind::kCapsule ? "capsule" : "cylinder",
                         mm(shape.radius),
                         shape.kind == scene::ShapeKind::kCapsule ? "straight part" : "length",
                         mm(2 * shape.half_length));
    case scene::ShapeKind::kConvexMesh:
      return fmt::format("convex hull of {} corners and {} faces", shape.mesh->vertices().size(),
                         shape.mesh->faces().size());
    case scene::ShapeKind::kUnion:
      break;
  }
  return "several parts";
}

void print_bodies(Inspected& of) {
  fmt::print("bodies\n");
  for (const mjcf::ObjectFile& file : of.files) {
    const scene::Object& object = file.object;
    const Vector3d principal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(object.inertia).eigenvalues();
    fmt::print(
        "  {}: mass {:.4g} kg, principal inertia {:.3g} {:.3g} {:.3g} kg m2, friction {:.3g}, "
        "{:.4g} x {:.4g} x {:.4g} mm\n",
        object.name, object.mass, principal[0], principal[1], principal[2], object.friction,
        extent(object, Vector3d::UnitX()) / kMillimetre,
        extent(object, Vector3d::UnitY()) / kMillimetre,
        extent(object, Vector3d::UnitZ()) / kMillimetre);
    for (const scene::Part& part : object.parts->parts) {
      fmt::print("    {} at {:.4g} {:.4g} {:.4g} mm from the centre of mass\n",
                 describe(part.shape), millimetres(part.p_BP.x()), millimetres(part.p_BP.y()),
                 millimetres(part.p_BP.z()));
    }
    for (const std::string& note : file.notes) of.warnings.push_back(object.name + ": " + note);
    // a rod along its own axis, say: Euler's equation has no answer to a turn about it
    if (principal[0] < 1e-9 * principal[2])
      of.warnings.push_back(object.name + ": one principal inertia is next to nothing");
  }
}

/// Of two parts MuJoCo adds up the masses, whether they overlap or not.
void warn_of_overlap(Inspected& of) {
  for (const mjcf::ObjectFile& file : of.files) {
    const std::vector<scene::Part>& parts = file.object.parts->parts;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      for (std::size_t j = i + 1; j < parts.size(); ++j) {
        const double gap = scene::separation(parts[i].shape, {parts[i].p_BP, parts[i].R_BP},
                                             parts[j].shape, {parts[j].p_BP, parts[j].R_BP})
                               .distance;
        if (gap >= -0.1 * kMillimetre) continue;
        of.warnings.push_back(fmt::format(
            "{}: its parts {} and {} overlap by {:.3g} mm: unless the file gives the inertia, what "
            "they share has been weighed twice",
            file.object.name, i + 1, j + 1, -gap / kMillimetre));
      }
    }
  }
}

/// So that no -0.000 is printed.
double rounded(double value) { return std::round(1e3 * value) / 1e3 + 0.0; }

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

void print_conditioning(const lcs::Lcs& lcs) {
  const VectorXd of_F = Eigen::JacobiSVD<MatrixXd>(lcs.F).singularValues();
  const auto rank = [](const VectorXd& values) {
    return (values.array() > 1e-9 * values[0]).count();
  };
  const Eigen::Index n_F = rank(of_F);
  const double symmetric = (lcs.F - lcs.F.transpose()).cwiseAbs().maxCoeff();
  const double least =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(0.5 * (lcs.F + lcs.F.transpose())).eigenvalues()[0];
  fmt::print("conditioning\n  F: rank {} of {}, singular values {:.3g} to {:.3g}, {}\n", n_F,
             lcs.F.rows(), of_F[n_F - 1], of_F[0],
             symmetric > 1e-12 * of_F[0] ? "not symmetric"
             : least > -1e-9 * of_F[0]   ? "symmetric, positive semidefinite"
                                         : "symmetric, indefinite");
  const double scale = lcs::force_scale(lcs);
  lcs::Lcs scaled = lcs;
  lcs::scale_forces(scaled, scale);
  MatrixXd ABD(lcs.A.rows(), lcs.A.cols() + lcs.B.cols() + lcs.D.cols());
  ABD << scaled.A, scaled.B, scaled.D;
  const VectorXd of_ABD = Eigen::JacobiSVD<MatrixXd>(ABD).singularValues();
  fmt::print("  scaled by {:.3g}: |D| {:.3g} beside |A| {:.3g}, [A B D] from {:.3g} to {:.3g}\n",
             scale, scaled.D.norm(), scaled.A.norm(), of_ABD[rank(of_ABD) - 1], of_ABD[0]);
}

void print_errors(Inspected& of, model::ContactModel contact_model, double step) {
  fmt::print(
      "error of each block against finite differences of the step (relative; d and c: of x "
      "and eta)\n  {:<34}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
      "", "A", "B", "D", "d", "E", "F", "H", "c");
  const auto row = [&](const char* name, const scene::Scene& scene) {
    const model::BlockErrors e =
        model::block_errors(*of.model, contact_model, scene, of.contacts, step);
    fmt::print("  {:<34}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}\n", name,
               e.A, e.B, e.D, e.d, e.E, e.F, e.H, e.c);
    return e;
  };
  const model::BlockErrors resting = row("at rest", of.scene);
  scene::Scene moving = of.scene;
  for (int i = 0; i < moving.body_count; ++i) {
    moving.body(i).v_WB << kSpeed, 0.0, 0.0;
    moving.body(i).omega_WB << 0.0, 0.0, kTurn;
  }
  const model::BlockErrors turning =
      row(fmt::format("at {:g} m/s and {:g} rad/s", kSpeed, kTurn).c_str(), moving);
  if (resting.E > 0.05) {
    of.warnings.push_back(fmt::format(
        "E is off by {:.0f} % at rest: the LCS holds normals and lever arms still while an object "
        "turns; linearise anew every period",
        100.0 * resting.E));
  }
  if (turning.A > 0.1)
    of.warnings.emplace_back("A is off by more than 10 % where it turns: a shorter step is nearer");
}

nlohmann::json to_json(const MatrixXd& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    nlohmann::json row = nlohmann::json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

nlohmann::json to_json(const VectorXd& vector) {
  nlohmann::json values = nlohmann::json::array();
  for (const double value : vector) values.push_back(value);
  return values;
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
  const MatrixXd of_x = Q.asDiagonal();
  const nlohmann::json problem{
      {"schema", "c3-problem-1"},
      {"lcs",
       {{"A", to_json(lcs.A)},
        {"B", to_json(lcs.B)},
        {"D", to_json(lcs.D)},
        {"d", to_json(lcs.d)},
        {"E", to_json(lcs.E)},
        {"F", to_json(lcs.F)},
        {"H", to_json(lcs.H)},
        {"c", to_json(lcs.c)}}},
      {"x0", to_json(x0)},
      {"projection", "C3+"},
      {"params",
       {{"N", 10},
        {"s", 2},
        {"rho", 1.0},
        {"rho_s", 3.0},
        {"Q", to_json(of_x)},
        {"R", to_json(MatrixXd(1e-5 * MatrixXd::Identity(layout.n_u, layout.n_u)))},
        {"QN", to_json(of_x)},
        {"xd", to_json(wanted)},
        {"delta0", "x0"},
        {"u_lambda", 10.0},
        {"u_eta", 1.0},
        {"g_lambda", 0.1},
        {"g_eta", 0.01}}}};
  return problem.dump(1) + "\n";
}

}  // namespace

std::vector<std::string> inspect_pairs() {
  return {"end_effector_object", "object_table", "object_object"};
}

int inspect(const InspectSettings& settings) {
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
  print_bodies(of);
  warn_of_overlap(of);
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
  fmt::print("mind\n");
  for (const std::string& warning : of.warnings) fmt::print("  - {}\n", warning);
  if (!settings.out.empty()) {
    write_text(settings.out, problem_of(of, lcs));
    fmt::print("written: {}: C3+ on this LCS, every object 0.1 m along x (c3rt solve {})\n",
               settings.out, settings.out);
  }
  return kDone;
}

}  // namespace c3rt::cli
