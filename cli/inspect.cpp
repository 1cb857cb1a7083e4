#include "cli/inspect.hpp"

#include <fmt/format.h>

#include "cli/inspect_lcs.hpp"
#include "cli/inspect_mechanism.hpp"
#include "cli/inspect_report.hpp"
#include "cli/millimetres.hpp"
#include "cli/paths.hpp"
#include "controller/lcs/lcs.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/model/objects_model.hpp"
#include "controller/model/support_points.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

std::string name_of(const scene::Scene& scene, int body) {
  if (body == model::ContactPair::kEndEffector) return "end effector";
  if (body == model::ContactPair::kTable) return "table";
  return scene.body(body).name.c_str();
}

void print_pairs(const SeenObjects& of, std::vector<std::string>& warnings) {
  const model::ContactSystem& system = of.system;
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
      warnings.push_back(fmt::format("{} and {} overlap by {:.3g} mm where it is inspected",
                                     name_of(of.scene, contact.bodies.first),
                                     name_of(of.scene, contact.bodies.second), -gap / kMillimetre));
    }
  }
}

void print_errors(const SeenObjects& of, double step, std::vector<std::string>& warnings) {
  print_error_heading();
  const auto row = [&](const std::string& name, const scene::Scene& scene) {
    const model::BlockErrors errors =
        model::block_errors(*of.model, of.contact_model, scene, of.contacts, step);
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
  warn_of_errors(resting, turning, warnings);
}

int inspect_objects(const InspectSettings& settings) {
  const SeenObjects of = see_objects(settings);
  const model::Layout& layout = of.model->layout();
  std::vector<std::string> warnings;
  fmt::print("bodies\n");
  for (const mjcf::ObjectFile& file : of.files) {
    print_object(file.object, warnings);
    for (const std::string& note : file.notes) warnings.push_back(file.object.name + ": " + note);
  }
  print_pairs(of, warnings);
  fmt::print(
      "sizes\n  n_x {}, n_u {}, n_lambda {}: {}, {} contacts with {} edges each, step {:g} s\n",
      layout.n_x, layout.n_u, of.lcs.F.rows(), settings.contact_model, of.contacts.size(),
      layout.n_e, settings.step);
  print_conditioning(of.lcs);
  print_errors(of, settings.step, warnings);
  for (const mjcf::ObjectFile& file : of.files) {
    const int points = model::SupportPoints(file.object, settings.support_points).size();
    if (points < 3) {
      warnings.push_back(fmt::format(
          "{}: {} support point{}: nothing but its roundness resists a turn on the table",
          file.object.name, points, points == 1 ? "" : "s"));
    }
  }
  warnings.emplace_back(
      "a plan that believes its object larger than it is waits for contact that is not there: "
      "keep the model true or up to 3 % smaller (model.size_scale)");
  print_warnings(warnings);
  if (!settings.out.empty()) {
    write_text(settings.out, problem_file(of));
    fmt::print("written: {}: C3+ on this LCS, every object 0.1 m along x (c3rt solve {})\n",
               settings.out, settings.out);
  }
  return kDone;
}

}  // namespace

int inspect(const InspectSettings& settings) {
  return has_motors(settings) ? inspect_mechanism(settings) : inspect_objects(settings);
}

}  // namespace c3rt::cli
