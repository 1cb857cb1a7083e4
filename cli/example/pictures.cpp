#include "cli/example/pictures.hpp"

#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "controller/model/cart_pole.hpp"
#include "controller/model/finger_gaiting.hpp"
#include "controller/model/pivoting.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using example::Experiment;
using example::Trajectory;

constexpr const char* kUpperShade = "#cfe3f1";
constexpr const char* kLowerShade = "#f8ddcc";
constexpr double kPushes = 1e-3;  // a normal force above this is contact [N]

/// One experiment's curves over time.
struct Drawing {
  const Experiment& experiment;
  const Trajectory& trajectory;
  VectorXd t;  // of the states

  Drawing(const Experiment& e, const Trajectory& run)
      : experiment(e),
        trajectory(run),
        t(VectorXd::LinSpaced(run.x.cols(), 0.0,
                              static_cast<double>(run.steps()) * e.simulation_step)) {}

  VectorXd steps() const { return t.head(trajectory.steps()); }
  Curve x(int row, const char* name, const char* color) const {
    return {name, color, t, trajectory.x.row(row)};
  }
  Curve u(int row, const char* name, const char* color) const {
    return {name, color, steps(), trajectory.u.row(row)};
  }
  Curve lambda(int row, const char* name, const char* color) const {
    return {name, color, steps(), trajectory.lambda.row(row)};
  }
  Curve level(double y, const std::string& name, const char* color) const {
    return {name, color, Eigen::Vector2d(t[0], t[t.size() - 1]), Eigen::Vector2d(y, y), true};
  }
  std::vector<Shade> contact() const {
    using L = model::PivotingLayout;  // the same places as in finger gaiting
    const auto pushes = [this](int row) {
      const Eigen::Array<bool, Eigen::Dynamic, 1> on =
          trajectory.u.row(row).transpose().array() > kPushes;
      return intervals(t, on);
    };
    return {{"finger 1 pushes", kUpperShade, 0.5, 1.0, pushes(L::normal_1)},
            {"finger 2 pushes", kLowerShade, 0.0, 0.5, pushes(L::normal_2)}};
  }
};

std::vector<Panel> cart_pole(const Drawing& d, const model::CartPoleParameters& p) {
  using L = model::CartPoleLayout;
  VectorXd tip = d.trajectory.x.row(L::position);
  tip.array() -= p.pole_length * d.trajectory.x.row(L::angle).transpose().array().sin();
  return {{"",
           "",
           "position [m]",
           {d.x(L::position, "cart", kBlue),
            {"tip of the pole", kRed, d.t, tip},
            d.level(p.wall_distance, "walls", kAmber),
            d.level(-p.wall_distance, "", kAmber)}},
          {"", "", "angle of the pole [rad]", {d.x(L::angle, "angle", kBlue)}},
          {"",
           "time [s]",
           "force [N]",
           {d.u(0, "input", kInk), d.lambda(L::right_wall, "right wall", kRed),
            d.lambda(L::left_wall, "left wall", kBlue)}}};
}

std::vector<Panel> finger_gaiting(const Drawing& d) {
  using L = model::FingerGaitingLayout;
  Panel positions{"",
                  "",
                  "height [m]",
                  {d.x(L::object, "object", kInk), d.x(L::finger_1, "finger 1", kBlue),
                   d.x(L::finger_2, "finger 2", kRed),
                   d.level(d.experiment.x_desired[L::object], "goal of the object", kGrey)},
                  d.contact()};
  const c3::Constraints& constraints = d.experiment.constraints;
  bool named = false;
  for (const VectorXd* bound : {constraints.x_min.data(), constraints.x_max.data()}) {
    for (const double y : *bound) {
      if (!std::isfinite(y)) continue;
      positions.curves.push_back(d.level(y, named ? "" : "limits of the fingers", kAmber));
      named = true;
    }
  }
  return {positions,
          {"",
           "",
           "normal force [N]",
           {d.u(L::normal_1, "finger 1", kBlue), d.u(L::normal_2, "finger 2", kRed)}},
          {"",
           "time [s]",
           "acceleration [m/s²]",
           {d.u(L::acceleration_1, "finger 1", kBlue), d.u(L::acceleration_2, "finger 2", kRed)}}};
}

std::vector<Panel> pivoting(const Drawing& d) {
  using L = model::PivotingLayout;
  const VectorXd& goal = d.experiment.x_desired;
  return {{"",
           "",
           "angle α [rad]",
           {d.x(L::alpha, "α", kInk), d.level(goal[L::alpha], "goal", kGrey)},
           d.contact()},
          {"",
           "",
           "centre of the box [m]",
           {d.x(L::x, "x", kBlue), d.x(L::y, "y", kRed), d.level(goal[L::x], "goals", kGrey),
            d.level(goal[L::y], "", kGrey)}},
          {"",
           "",
           "fingers along their faces [m]",
           {d.x(L::finger_1, "finger 1", kBlue), d.x(L::finger_2, "finger 2", kRed),
            d.level(goal[L::finger_1], "goal", kGrey)}},
          {"",
           "time [s]",
           "normal force [N]",
           // without the ground's: one impact of a step would dwarf the others
           {d.u(L::normal_1, "finger 1", kBlue), d.u(L::normal_2, "finger 2", kRed)}}};
}

/// Of any other system: what has a length, what has an angle, with the goals that are weighed, and
/// the inputs.
std::vector<Panel> by_names(const Drawing& d, const model::SystemLayout& layout) {
  constexpr std::array kColors{kInk, kBlue, kRed, kAmber, kGrey};
  std::vector<Panel> panels;
  const auto color = [&](const Panel& panel) {
    return kColors[panel.curves.size() % kColors.size()];
  };
  for (const auto& [unit, label] :
       {std::pair{"m", "position [m]"}, std::pair{"rad", "angle [rad]"}}) {
    Panel panel{"", "", label, {}};
    std::vector<Curve> goals;
    for (int i = 0; i < layout.n_x(); ++i) {
      const model::Quantity& of = layout.x[static_cast<std::size_t>(i)];
      if (of.unit != unit) continue;
      if (d.experiment.costs.Q[0](i, i) > 0.0)
        goals.push_back(d.level(d.experiment.x_desired[i], "", color(panel)));
      panel.curves.push_back(d.x(i, of.name.c_str(), color(panel)));
    }
    panel.curves.insert(panel.curves.end(), goals.begin(), goals.end());
    if (!panel.curves.empty()) panels.push_back(panel);
  }
  Panel inputs{"", "time [s]", "input", {}};
  for (int i = 0; i < layout.n_u(); ++i) {
    const model::Quantity& of = layout.u[static_cast<std::size_t>(i)];
    inputs.curves.push_back(d.u(i, of.name.c_str(), color(inputs)));
  }
  panels.push_back(inputs);
  return panels;
}

}  // namespace

void write_trajectory(const std::filesystem::path& file, const Experiment& experiment,
                      const Trajectory& trajectory) {
  std::ostringstream stream;
  stream << "t_s";
  const model::SystemLayout& layout = experiment.plant->layout();
  for (const auto* group : {&layout.x, &layout.u, &layout.lambda}) {
    for (const model::Quantity& of : *group) stream << ',' << of.name << '_' << of.unit;
  }
  stream << ",accumulated_cost\n";
  const auto cells = [&](const Eigen::MatrixXd& matrix, Index column) {
    for (Index row = 0; row < matrix.rows(); ++row) {
      stream << (column < matrix.cols() ? fmt::format(",{:.9g}", matrix(row, column)) : ",");
    }
  };
  for (Index i = 0; i < trajectory.x.cols(); ++i) {
    stream << fmt::format("{:.9g}", static_cast<double>(i) * experiment.simulation_step);
    cells(trajectory.x, i);
    cells(trajectory.u, i);  // empty after the last step
    cells(trajectory.lambda, i);
    stream << fmt::format(",{:.9g}\n", trajectory.cost[i]);
  }
  write_text(file, stream.str());
}

std::vector<Panel> trajectory_panels(const Experiment& experiment, const Trajectory& trajectory) {
  const Drawing drawing(experiment, trajectory);
  const model::SystemModel& plant = *experiment.plant;
  if (const auto* of = dynamic_cast<const model::CartPole*>(&plant); of != nullptr)
    return cart_pole(drawing, of->parameters());
  if (dynamic_cast<const model::FingerGaiting*>(&plant) != nullptr) return finger_gaiting(drawing);
  if (dynamic_cast<const model::Pivoting*>(&plant) != nullptr) return pivoting(drawing);
  return by_names(drawing, plant.layout());
}

}  // namespace c3rt::cli
