#include "cli/gap/recorded.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "cli/progress.hpp"
#include "cli/recording/recording.hpp"
#include "controller/planner/c3_controller.hpp"
#include "controller/planner/strategy/heuristic.hpp"
#include "idl/text.hpp"

namespace c3rt::cli::gap {
namespace {

using Eigen::Vector3d;

constexpr double kNs = 1e-9;
constexpr std::int64_t kApart = 2'000'000;  // of the two states that give a velocity [ns]

Vector3d vector(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

struct ObjectRow {
  std::int64_t time_ns;
  Vector3d p_WB, v_WB, omega_WB;
};
struct EffectorRow {
  std::int64_t time_ns;
  Vector3d p_WE;
};

/// Keeps what questions are made of.
class Keeper final : public Listener {
 public:
  void hear(const wire::Scene& scene) override {
    const auto& object = scene.objects[0];
    objects.push_back({scene.header.time_ns, vector(object.p_WB_m), vector(object.v_WB_m_per_s),
                       vector(object.omega_rad_per_s)});
  }
  void hear(const wire::RobotState& state) override {
    effector.push_back({state.header.time_ns, vector(state.p_WE_m)});
  }
  void hear(const wire::Plan& plan) override {
    if (wire::is_at_task(plan.phase)) instants.push_back(plan.origin.state_ns);
  }

  std::vector<ObjectRow> objects;
  std::vector<EffectorRow> effector;
  std::vector<std::int64_t> instants;  // of the states that were planned from [ns]
};

/// The last row that is not later, or the first.
template <typename Row>
const Row& before(const std::vector<Row>& rows, std::int64_t time_ns) {
  const auto after =
      std::upper_bound(rows.begin(), rows.end(), time_ns,
                       [](std::int64_t t, const Row& row) { return t < row.time_ns; });
  return after == rows.begin() ? *after : *std::prev(after);
}

void require_heuristic(const config::Scenario& scenario) {
  const planner::Parameters& planner = scenario.planner;
  if (planner.strategy == "time_heuristic" && planner.model.bodies == 1) return;
  throw UsageError(
      fmt::format("{}: c3rt gap asks planners of one body and the strategy time_heuristic, got {} "
                  "and {}",
                  scenario.name, planner.model.bodies, planner.strategy));
}

/// A scenario's planner that is asked one question after the other.
class Planner {
 public:
  explicit Planner(const config::Scenario& scenario)
      : parameters_(scenario.planner),
        c3_(parameters_),
        roll_(c3_.add_costs(planner::costs_of(c3_.problem(), parameters_.roll))),
        back_(c3_.add_costs(planner::costs_of(c3_.problem(), parameters_.back))) {}

  Answer answer(const Question& question) {
    for (int k = 0; k <= parameters_.N; ++k)
      c3_.want(k, question.desired[static_cast<std::size_t>(k)], question.scene);
    const double began = processor_seconds_now();
    const planner::StepStatus status =
        c3_.step(question.scene, question.rolling ? roll_ : back_, 1.0 / parameters_.rate, {});
    Answer answer{{}, processor_seconds_now() - began};
    if (status == planner::StepStatus::kFailed) return answer;
    // after the inputs C3+ has its η
    answer.u = c3_.result().input_scale *
               c3_.result().solution->z.middleRows(c3_.n_x() + c3_.n_lambda(), c3_.n_u());
    return answer;
  }

 private:
  const planner::Parameters& parameters_;
  planner::C3Controller c3_;
  int roll_, back_;
};

}  // namespace

std::vector<Question> questions(const std::filesystem::path& recording,
                                const config::Scenario& scenario, int count) {
  require_heuristic(scenario);
  Keeper kept;
  (void)play(recording, kept);
  if (kept.instants.empty() || kept.objects.empty() || kept.effector.empty())
    throw std::runtime_error(recording.string() + ": the run never began its task");

  const planner::Parameters& parameters = scenario.planner;
  const double radius = planner::make_model(parameters.model)->layout().world.body(0).shape.radius;
  std::vector<Question> all;
  for (int i = 0; i < count; ++i) {
    const std::int64_t now = kept.instants[kept.instants.size() * static_cast<std::size_t>(i) /
                                           static_cast<std::size_t>(count)];
    Question question{static_cast<double>(now - kept.instants.front()) * kNs, {}, false, {}};
    const EffectorRow &state = before(kept.effector, now),
                      &earlier = before(kept.effector, now - kApart);
    scene::Scene& scene = question.scene;
    scene::Effector& effector = scene.effector;
    effector.p_WE = state.p_WE;
    const double passed = static_cast<double>(state.time_ns - earlier.time_ns) * kNs;
    effector.v_WE = passed > 0.0 ? Vector3d((effector.p_WE - earlier.p_WE) / passed)
                                 : Vector3d(Vector3d::Zero());
    scene.body_count = 1;
    const ObjectRow& seen = before(kept.objects, now);
    scene::Body& object = scene.body(0);
    object.v_WB = seen.v_WB;
    object.p_WB = seen.p_WB + static_cast<double>(now - seen.time_ns) * kNs * object.v_WB;
    object.omega_WB = seen.omega_WB;
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

Decisions of_questions(const std::vector<Question>& questions, const config::Scenario& scenario) {
  require_heuristic(scenario);
  const planner::Parameters& parameters = scenario.planner;
  const std::unique_ptr<model::PlanningModel> model = planner::make_model(parameters.model);
  planner::PlanningProblem problem = planner::planning_problem(*model, parameters.model);
  problem.contact_model = model::ContactModel::kStewartTrinkle;
  Decisions decisions;
  decisions.name = scenario.name;
  decisions.costs = {planner::costs_of(problem, parameters.back),
                     planner::costs_of(problem, parameters.roll)};
  Planner planner(scenario);
  for (const Question& question : questions) {
    lcs::Lcs lcs =
        model::to_lcs(problem.contact_model,
                      model->contact_system(question.scene, problem.contacts), parameters.dt);
    lcs::scale_forces(lcs, lcs::force_scale(lcs));
    decisions.sizes = {static_cast<int>(lcs.A.rows()), static_cast<int>(lcs.F.rows()),
                       static_cast<int>(lcs.B.cols()), parameters.N};
    const int n_x = decisions.sizes.n_x;
    Eigen::VectorXd x0(n_x), x(n_x);
    model->state(question.scene, x0);
    Eigen::MatrixXd x_desired(n_x, parameters.N + 1);
    for (int k = 0; k <= parameters.N; ++k) {
      model->state(question.desired[static_cast<std::size_t>(k)], x);
      x_desired.col(k) = x;
    }
    const Answer answer = planner.answer(question);
    decisions.all.push_back({question.time,
                             {std::move(lcs)},
                             x0,
                             answer.u,
                             answer.solve_time_s,
                             x_desired,
                             question.rolling ? std::size_t{1} : std::size_t{0}});
  }
  return decisions;
}

std::vector<Answer> answers(const std::vector<Question>& questions,
                            const config::Scenario& scenario, const config::Scenario& planner) {
  require_heuristic(planner);
  const auto told = [](const planner::Parameters& of) {
    return fmt::format("a horizon of {} and a step of {:g} s", of.N, of.dt);
  };
  const std::string expected = told(scenario.planner), got = told(planner.planner);
  if (got != expected)
    throw UsageError(fmt::format("{}: expected {}, got {}", planner.name, expected, got));
  Planner asked(planner);
  std::vector<Answer> all;
  for (const Question& question : questions) all.push_back(asked.answer(question));
  return all;
}

}  // namespace c3rt::cli::gap
