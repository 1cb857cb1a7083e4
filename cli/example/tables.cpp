#include "cli/example/tables.hpp"

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "cli/paths.hpp"

namespace c3rt::cli {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// With as many digits as give the same number again; empty where there is none.
std::string cell(double value) {
  return std::isfinite(value) ? fmt::format(",{}", value) : std::string(",");
}

Index steps_per_decision(const example::Experiment& experiment) {
  return std::lround(experiment.control_period / experiment.simulation_step);
}

}  // namespace

VectorXd actual_costs(const example::Experiment& experiment,
                      const example::Trajectory& trajectory) {
  const Index held = steps_per_decision(experiment);
  const Index decisions = trajectory.cost_to_go.size();
  VectorXd costs = VectorXd::Constant(decisions, kNone);
  for (Index i = 0; (i + experiment.N) * held < trajectory.x.cols(); ++i) {
    double cost = 0.0;
    for (Index k = i; k < i + experiment.N; ++k)
      cost +=
          example::stage_cost(experiment, trajectory.x.col(k * held), trajectory.u.col(k * held));
    const VectorXd e = trajectory.x.col((i + experiment.N) * held) - experiment.x_desired;
    costs[i] = cost + e.dot(experiment.costs.Q_N * e);
  }
  return costs;
}

void write_decisions(const std::filesystem::path& file, const example::Experiment& experiment,
                     const TrialsResult& result) {
  const example::Trajectory& trajectory = result.first;
  const VectorXd came = actual_costs(experiment, trajectory);
  const bool is_exact = !result.exact.empty(), is_traced = !result.projections.empty();
  std::string text = "t_s,cost_to_go,actual_cost,solve_time_s";
  if (is_exact) text += ",gap,proven";
  if (is_traced) text += ",projection_s,projections_not_solved";
  text += "\n";
  for (Index i = 0; i < trajectory.cost_to_go.size(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    text += fmt::format("{}", static_cast<double>(i) * experiment.control_period) +
            cell(trajectory.cost_to_go[i]) + cell(came[i]) + cell(result.solve_times[row]);
    if (is_exact) text += cell(result.exact[row].gap) + (result.exact[row].proven ? ",1" : ",0");
    if (is_traced) {
      const ProjectionTimes& times = result.projections[row];
      text += cell(times.mean) + fmt::format(",{}", times.not_solved);
    }
    text += "\n";
  }
  write_text(file, text);
}

void write_iterates(const std::filesystem::path& file, const example::Experiment& experiment,
                    const TrialsResult& result) {
  const c3::Sizes s = example::sizes(experiment);
  const model::SystemLayout& layout = experiment.model->layout();
  std::string text = "iteration,stage";
  for (const auto* group : {&layout.x, &layout.lambda, &layout.u}) {
    for (const model::Quantity& of : *group) text += "," + of.name + "_" + of.unit;
    if (group != &layout.lambda) continue;
    for (const model::Quantity& of : *group) text += ",gap_of_" + of.name;
  }
  text += "\n";
  const lcs::Lcs& lcs = result.first_system;
  for (std::size_t i = 0; i < result.first_iterates.size(); ++i) {
    for (int k = 0; k < s.N; ++k) {
      const VectorXd z = result.first_iterates[i].z.col(k);
      const VectorXd gaps = lcs.E * s.x(z) + lcs.F * s.lambda(z) + lcs.H * s.u(z) + lcs.c;
      text += fmt::format("{},{}", i + 1, k);
      for (const VectorXd& group :
           {VectorXd(s.x(z)), VectorXd(s.lambda(z)), gaps, VectorXd(s.u(z))})
        for (const double value : group) text += cell(value);
      text += "\n";
    }
  }
  write_text(file, text);
}

}  // namespace c3rt::cli
