#include "cli/reproduce/open_loop.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/progress.hpp"
#include "cli/reproduce/rolling.hpp"
#include "controller/horizon/modes.hpp"
#include "controller/horizon/search.hpp"
#include "controller/lcs/simulate.hpp"
#include "controller/planner/c3_controller.hpp"
#include "controller/planner/strategy/heuristic.hpp"

namespace c3rt::cli::reproduce {
namespace {

constexpr double kNs = 1e-9;

/// The problem that the judge's planner would solve: its LCS, with scaled forces, and its costs.
struct Posed {
  lcs::Lcs lcs;
  c3::Costs costs;
  c3::Constraints constraints;
  horizon::Problem problem;
};

Posed pose(const Question& question, const planner::Parameters& parameters) {
  const std::unique_ptr<model::PlanningModel> model = planner::make_model(parameters.model);
  planner::PlanningProblem problem = planner::planning_problem(*model, parameters.model);
  problem.contact_model = model::ContactModel::kStewartTrinkle;
  Posed posed;
  posed.lcs = model::to_lcs(problem.contact_model,
                            model->contact_system(question.scene, problem.contacts), parameters.dt);
  lcs::scale_forces(posed.lcs, lcs::force_scale(posed.lcs));
  posed.costs = planner::costs_of(problem, question.rolling ? parameters.roll : parameters.back);
  const c3::Sizes sizes{static_cast<int>(posed.lcs.A.rows()), static_cast<int>(posed.lcs.F.rows()),
                        static_cast<int>(posed.lcs.B.cols()), parameters.N};
  posed.problem.sizes = sizes;
  posed.problem.x0.resize(sizes.n_x);
  model->state(question.scene, posed.problem.x0);
  posed.problem.x_desired.resize(sizes.n_x, sizes.N + 1);
  Eigen::VectorXd x(sizes.n_x);
  for (int k = 0; k <= sizes.N; ++k) {
    model->state(question.desired[static_cast<std::size_t>(k)], x);
    posed.problem.x_desired.col(k) = x;
  }
  return posed;
}

/// The costs of Phase I and II.
struct PhaseCosts {
  int roll, back;
  PhaseCosts(planner::C3Controller& c3, const planner::Parameters& parameters)
      : roll(c3.add_costs(planner::costs_of(c3.problem(), parameters.roll))),
        back(c3.add_costs(planner::costs_of(c3.problem(), parameters.back))) {}
  int of(const Question& question) const { return question.rolling ? roll : back; }
};

/// Points the problem at the data beside it, wherever that has been moved to.
const horizon::Problem& linked(Posed& posed) {
  posed.problem.systems = {&posed.lcs, 0};
  posed.problem.costs = &posed.costs;
  posed.problem.constraints = &posed.constraints;
  return posed.problem;
}

/// The trajectory that the inputs lead to; nothing where an LCP on the way has no answer.
std::optional<horizon::Plan> consequence(Posed& posed, const Eigen::MatrixXd& u) {
  const lcs::Simulation simulation = lcs::simulate(posed.lcs, posed.problem.x0, u);
  if (!simulation.report.ok()) return std::nullopt;
  return horizon::roll_out(linked(posed), simulation.lambda, u);
}

bool is_late(void* end) noexcept { return seconds_now() >= *static_cast<const double*>(end); }

/// The last row that is not later. @param rows begin with their time
const std::vector<double>& before(const std::vector<std::vector<double>>& rows, double time) {
  const auto after =
      std::upper_bound(rows.begin(), rows.end(), time,
                       [](double t, const std::vector<double>& row) { return t < row[0]; });
  return after == rows.begin() ? *after : *std::prev(after);
}

Eigen::Vector3d vector(const std::vector<double>& row, std::size_t at) {
  return {row[at], row[at + 1], row[at + 2]};
}

}  // namespace

std::vector<Question> questions(const Run& run, const config::Scenario& scenario, int count) {
  const std::filesystem::path logs = tables_of(run);
  const auto objects =
      read_columns(logs / "sim_scene.csv",
                   {"time_ns", "objects_0_p_WB_m_0", "objects_0_p_WB_m_1", "objects_0_p_WB_m_2",
                    "objects_0_v_WB_m_per_s_0", "objects_0_v_WB_m_per_s_1",
                    "objects_0_v_WB_m_per_s_2", "objects_0_omega_rad_per_s_0",
                    "objects_0_omega_rad_per_s_1", "objects_0_omega_rad_per_s_2"});
  const auto states =
      read_columns(logs / "robot_state.csv", {"time_ns", "p_WE_m_0", "p_WE_m_1", "p_WE_m_2"});
  const std::vector<double> instants = c3_instants(run);

  const planner::Parameters& parameters = scenario.planner;
  const double radius = planner::make_model(parameters.model)->layout().world.body(0).shape.radius;
  std::vector<Question> all;
  for (int i = 0; i < count; ++i) {
    const double now =
        instants[instants.size() * static_cast<std::size_t>(i) / static_cast<std::size_t>(count)];
    Question question{(now - instants.front()) * kNs, {}, false, {}};
    const std::vector<double>&state = before(states, now), &earlier = before(states, now - 2e6);
    scene::Scene& scene = question.scene;
    scene::Effector& effector = scene.effector;
    effector.p_WE = vector(state, 1);
    const double passed = (state[0] - earlier[0]) * kNs;
    effector.v_WE = passed > 0.0 ? Eigen::Vector3d((effector.p_WE - vector(earlier, 1)) / passed)
                                 : Eigen::Vector3d(Eigen::Vector3d::Zero());
    scene.body_count = 1;
    const std::vector<double>& seen = before(objects, now);
    scene::Body& object = scene.body(0);
    object.v_WB = vector(seen, 4);
    object.p_WB = vector(seen, 1) + (now - seen[0]) * kNs * object.v_WB;
    object.omega_WB = vector(seen, 7);
    object.q_WB.setIdentity();

    const planner::Phase phase = planner::phase_at(parameters.heuristic, question.time);
    question.rolling = phase == planner::Phase::kRoll;
    const auto target = [&](double ahead) {
      return parameters.task.target(scene, 0, question.time, ahead);
    };
    scene::Scene desired;
    desired.body_count = 1;
    desired.effector.p_WE =
        planner::end_effector_target(parameters.heuristic, parameters.geometry, phase,
                                     effector.p_WE, radius, object.p_WB, target(0.0));
    for (int k = 0; k <= parameters.N; ++k) {
      desired.body(0).p_WB << target(k * parameters.dt), parameters.geometry.table_height + radius;
      question.desired.push_back(desired);
    }
    all.push_back(std::move(question));
  }
  return all;
}

Answers answer_with_c3(const std::vector<Question>& questions, const config::Scenario& scenario,
                       const config::Scenario& judge) {
  planner::C3Controller step(scenario.planner);
  const PhaseCosts costs(step, scenario.planner);
  Answers answers;
  for (const Question& question : questions) {
    for (int k = 0; k <= scenario.planner.N; ++k)
      step.want(k, question.desired[static_cast<std::size_t>(k)], question.scene);
    const double began = seconds_now();
    const planner::StepStatus status =
        step.step(question.scene, costs.of(question), 1.0 / scenario.planner.rate, {});
    answers.times.push_back(seconds_now() - began);
    answers.costs.push_back(kNone);
    if (status == planner::StepStatus::kFailed) continue;
    const c3::Solution& solution = *step.result().solution;
    Posed posed = pose(question, judge.planner);
    const Eigen::MatrixXd u =
        solution.z.bottomRows(posed.problem.sizes.n_u).leftCols(posed.problem.sizes.N);
    if (const auto plan = consequence(posed, u)) answers.costs.back() = plan->objective;
  }
  return answers;
}

MonolithicAnswers answer_monolithic(const std::vector<Question>& questions,
                                    const config::Scenario& judge, double limit,
                                    const Context& context) {
  planner::C3Controller step(judge.planner);
  const PhaseCosts phase_costs(step, judge.planner);
  MonolithicAnswers answers;
  Progress progress("(15)");
  for (const Question& question : questions) {
    if (context.stopped()) throw Interrupted{};
    progress.update(
        static_cast<double>(answers.times.size()) / static_cast<double>(questions.size()),
        fmt::format("{} of {} proven", answers.proven, answers.times.size()));
    Posed posed = pose(question, judge.planner);
    const horizon::Problem& problem = linked(posed);
    for (int k = 0; k <= judge.planner.N; ++k)
      step.want(k, question.desired[static_cast<std::size_t>(k)], question.scene);
    const double began = seconds_now();
    // the modes that C3's inputs lead to are a first answer
    std::optional<horizon::Plan> known;
    if (step.step(question.scene, phase_costs.of(question), 1.0 / judge.planner.rate, {}) !=
        planner::StepStatus::kFailed) {
      const Eigen::MatrixXd u =
          step.result().solution->z.bottomRows(problem.sizes.n_u).leftCols(problem.sizes.N);
      if (const auto plan = consequence(posed, u))
        known = horizon::solve_modes(problem, horizon::modes(problem, *plan));
    }
    double end = began + limit;
    const horizon::SearchResult result = horizon::search(problem, {}, known, {&is_late, &end});
    answers.times.push_back(seconds_now() - began);
    answers.proven += result.is_proven() ? 1 : 0;
    answers.costs.push_back(kNone);
    // its inputs are judged as C3's are: what the system does with them, not what the plan says
    if (!result.plan) continue;
    if (const auto plan = consequence(posed, result.plan->u))
      answers.costs.back() = plan->objective;
  }
  return answers;
}

}  // namespace c3rt::cli::reproduce
