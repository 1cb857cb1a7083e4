#include "cli/inspect_mechanism.hpp"

#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "cli/inspect_report.hpp"
#include "cli/millimetres.hpp"
#include "cli/paths.hpp"
#include "cli/run.hpp"
#include "config/text.hpp"
#include "controller/mjcf/mechanism.hpp"
#include "controller/model/mechanism_model.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Kind = scene::Coordinate::Kind;

constexpr double kGoal = 0.1;  // of the written problem [m], [rad]

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

struct WrittenGoal {
  VectorXd x0, Q, x_desired;
  std::string text;
};

/// What no motor moves is brought somewhere: all free bodies along x, else the first joint of those
/// without a motor, else the first.
WrittenGoal goal_of(const scene::Mechanism& mechanism) {
  const int n_v = mechanism.n_v();
  WrittenGoal goal{VectorXd::Zero(2 * n_v), VectorXd::Zero(2 * n_v), {}, {}};
  goal.x0.head(n_v) = mechanism.home();
  goal.x_desired = goal.x0;
  int joint = -1;
  for (int i = 0; i < n_v; ++i) {
    const scene::Coordinate& of = mechanism.coordinates()[static_cast<std::size_t>(i)];
    const bool driven = mechanism.bodies()[static_cast<std::size_t>(of.body)].driven;
    const char axis = of.name.back();
    double &of_q = goal.Q[i], &of_v = goal.Q[n_v + i];
    if (of.kind == Kind::kPosition) {
      of_q = axis == 'z' ? 0.0 : 1.0;
      of_v = 1e-4;
      if (axis == 'x') {
        goal.x_desired[i] += kGoal;
        goal.text += (goal.text.empty() ? "" : ", ") + of.name;
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
  if (goal.text.empty() && joint >= 0) {
    goal.Q[joint] = 1.0;
    goal.x_desired[joint] += kGoal;
    goal.text = mechanism.coordinates()[static_cast<std::size_t>(joint)].name;
  }
  return goal;
}

}  // namespace

int inspect_mechanism(const InspectSettings& settings) {
  if (settings.models.size() != 1)
    throw UsageError("lcs inspect: expected one file where it has motors, got " +
                     std::to_string(settings.models.size()));
  if (!settings.effector.empty())
    throw UsageError("--effector: expected objects alone, got a model with motors of its own");
  std::vector<std::string> warnings;
  std::unique_ptr<model::MechanismModel> model;
  try {
    mjcf::MechanismFile file = mjcf::read_mechanism(settings.models[0]);
    warnings = std::move(file.notes);
    model::MechanismParameters parameters;
    for (const std::string& pair : settings.pairs) parameters.contacts.push_back(between_of(pair));
    if (settings.pairs.empty()) parameters.contacts = all_pairs(*file.mechanism);
    parameters.mechanism = std::move(file.mechanism);
    parameters.contact_model = settings.contact_model == "stewart_trinkle"
                                   ? model::ContactModel::kStewartTrinkle
                                   : model::ContactModel::kAnitescu;
    parameters.directions = settings.directions.value_or(parameters.directions);
    parameters.support_points = settings.support_points;
    if (!settings.across.empty())
      parameters.across = Vector3d(settings.across[0], settings.across[1], settings.across[2]);
    model = std::make_unique<model::MechanismModel>(parameters);
  } catch (const mjcf::Error& e) {
    throw UsageError(e.what());
  } catch (const std::invalid_argument& e) {
    throw UsageError(settings.models[0] + ": " + e.what());
  }
  const scene::Mechanism& mechanism = model->mechanism();
  const WrittenGoal goal = goal_of(mechanism);
  model::ContactSystem system;
  model->evaluate(goal.x0, system);
  const lcs::Lcs lcs = model::to_lcs(model->contact_model(), system, settings.step);
  print_coordinates(mechanism);
  fmt::print("bodies\n");
  for (std::size_t i = 1; i < mechanism.bodies().size(); ++i)
    print_object(mechanism.bodies()[i].object, warnings);
  print_contacts(*model, system, warnings);
  fmt::print(
      "sizes\n  n_x {}, n_u {}, n_lambda {}: {}, {} contacts with {} edges each, step {:g} s\n",
      lcs.A.rows(), lcs.B.cols(), lcs.F.rows(), settings.contact_model, model->n_c(), model->n_e(),
      settings.step);
  print_conditioning(lcs);
  print_errors(*model, settings.step, warnings);
  print_warnings(warnings);
  if (!settings.out.empty()) {
    VectorXd u_min(lcs.B.cols()), u_max(lcs.B.cols());
    for (Eigen::Index i = 0; i < u_min.size(); ++i) {
      u_min[i] = mechanism.motors()[static_cast<std::size_t>(i)].min;
      u_max[i] = mechanism.motors()[static_cast<std::size_t>(i)].max;
    }
    write_text(settings.out, problem_file(lcs, goal.x0, goal.Q, goal.x_desired, u_min, u_max));
    fmt::print("written: {}: C3+ on this LCS, {} by {:g} (c3rt solve {})\n", settings.out,
               goal.text, kGoal, settings.out);
  }
  return kDone;
}

}  // namespace c3rt::cli
