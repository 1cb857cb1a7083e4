#include "cli/inspect_mechanism.hpp"

#include <cmath>

#include <fmt/format.h>

#include "cli/inspect_lcs.hpp"
#include "cli/inspect_report.hpp"
#include "cli/millimetres.hpp"
#include "cli/paths.hpp"
#include "controller/model/mechanism_model.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Kind = scene::Coordinate::Kind;

bool turns(const scene::Coordinate& of) {
  return of.kind == Kind::kHinge || of.kind == Kind::kRotation;
}

void print_coordinates(const scene::Mechanism& mechanism) {
  fmt::print("coordinates, where they are at home\n");
  for (int i = 0; i < mechanism.n_v(); ++i) {
    const scene::Coordinate& of = mechanism.coordinates()[static_cast<std::size_t>(i)];
    const double home = mechanism.home()[i];
    const char* kind = of.kind == Kind::kSlide   ? "slide"
                       : of.kind == Kind::kHinge ? "hinge"
                                                 : "free body";
    fmt::print("  {}: {}, {:.4g} {}\n", of.name, kind,
               turns(of) ? rounded(home) : millimetres(home), turns(of) ? "rad" : "mm");
  }
  fmt::print("motors\n");
  for (const scene::Motor& motor : mechanism.motors()) {
    const char* unit = motor.turns ? "N m" : "N";
    if (std::isfinite(motor.min)) {
      fmt::print("  {}: {:g} to {:g} {}\n", motor.name, motor.min, motor.max, unit);
    } else {
      fmt::print("  {}: any {}\n", motor.name, unit);
    }
  }
}

std::string name_of(const scene::Mechanism& mechanism, int body, int surface) {
  if (surface >= 0) return mechanism.surfaces()[static_cast<std::size_t>(surface)].name;
  return mechanism.bodies()[static_cast<std::size_t>(body)].object.name;
}

void print_contacts(const model::MechanismModel& model, const model::ContactSystem& system,
                    std::vector<std::string>& warnings) {
  fmt::print("contacts\n");
  for (std::size_t i = 0; i < model.contacts().size(); ++i) {
    const model::MechanismModel::Contact& of = model.contacts()[i];
    const std::string first = name_of(model.mechanism(), of.first, of.first_surface),
                      second = name_of(model.mechanism(), of.second, of.second_surface);
    const double gap = system.distance[static_cast<Eigen::Index>(i)];
    fmt::print(
        "  {} and {}: gap {:.4g} mm at {:.4g} {:.4g} {:.4g} mm, normal {:.3f} {:.3f} {:.3f}, "
        "friction {:.3g}\n",
        first, second, millimetres(gap), millimetres(of.p_first.x()), millimetres(of.p_first.y()),
        millimetres(of.p_first.z()), rounded(of.normal.x()), rounded(of.normal.y()),
        rounded(of.normal.z()), of.mu);
    if (gap < -0.1 * kMillimetre) {
      warnings.push_back(
          fmt::format("{} and {} overlap by {:.3g} mm at home", first, second, -gap / kMillimetre));
    }
  }
}

/// At home, with everything at rest or moving.
void print_errors(const model::MechanismModel& model, double step,
                  std::vector<std::string>& warnings) {
  const scene::Mechanism& mechanism = model.mechanism();
  VectorXd x = VectorXd::Zero(2 * mechanism.n_v());
  x.head(mechanism.n_v()) = mechanism.home();
  print_error_heading();
  const model::BlockErrors resting = model::block_errors(model, x, step);
  print_error_row("at rest", resting);
  for (int i = 0; i < mechanism.n_v(); ++i) {
    const scene::Coordinate& of = mechanism.coordinates()[static_cast<std::size_t>(i)];
    // of a free body along x and about z
    const bool moves = of.kind == Kind::kSlide || of.kind == Kind::kHinge ||
                       of.name.back() == (of.kind == Kind::kPosition ? 'x' : 'z');
    x[mechanism.n_v() + i] = moves ? (turns(of) ? kInspectedTurn : kInspectedSpeed) : 0.0;
  }
  const model::BlockErrors moving = model::block_errors(model, x, step);
  print_error_row(fmt::format("at {:g} m/s and {:g} rad/s", kInspectedSpeed, kInspectedTurn),
                  moving);
  warn_of_errors(resting, moving, warnings);
}

}  // namespace

int inspect_mechanism(const InspectSettings& settings) {
  SeenMechanism of = see_mechanism(settings);
  const scene::Mechanism& mechanism = of.model->mechanism();
  std::vector<std::string>& warnings = of.notes;
  print_coordinates(mechanism);
  fmt::print("bodies\n");
  for (std::size_t i = 1; i < mechanism.bodies().size(); ++i)
    print_object(mechanism.bodies()[i].object, warnings);
  print_contacts(*of.model, of.system, warnings);
  fmt::print(
      "sizes\n  n_x {}, n_u {}, n_lambda {}: {}, {} contacts with {} edges each, step {:g} s\n",
      of.lcs.A.rows(), of.lcs.B.cols(), of.lcs.F.rows(), settings.contact_model, of.model->n_c(),
      of.model->n_e(), settings.step);
  print_conditioning(of.lcs);
  print_errors(*of.model, settings.step, warnings);
  print_warnings(warnings);
  if (!settings.out.empty()) {
    write_text(settings.out, problem_file(of));
    fmt::print("written: {}: C3+ on this LCS, {} by {:g} (c3rt solve {})\n", settings.out, of.goal,
               kInspectedGoal, settings.out);
  }
  return kDone;
}

}  // namespace c3rt::cli
