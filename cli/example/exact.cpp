#include "cli/example/exact.hpp"

#include <utility>

#include "cli/report/series.hpp"
#include "controller/horizon/search.hpp"
#include "controller/lcs/simulate.hpp"

namespace c3rt::cli {

ExactController::ExactController(const example::Experiment& experiment, double limit, Stop stop)
    : experiment_(experiment),
      c3_(experiment),
      sizes_(example::sizes(experiment)),
      limit_(limit),
      stop_(std::move(stop)) {}

bool ExactController::is_late(void* self) noexcept {
  const auto& controller = *static_cast<const ExactController*>(self);
  return seconds_now() > controller.end_ || controller.stop_();
}

void ExactController::reset() {
  c3_.reset();
  last_.clear();
}

std::optional<horizon::Plan> ExactController::first_plan(const horizon::Problem& problem,
                                                         const lcs::Lcs& lcs, double t) {
  std::optional<horizon::Plan> best;
  const auto consider = [&](const std::vector<horizon::Side>& zero) {
    std::optional<horizon::Plan> plan = horizon::solve_modes(problem, zero);
    if (plan && (!best || plan->objective < best->objective)) best = std::move(plan);
  };
  if (const Eigen::MatrixXd* u = c3_.decide(lcs, problem.x0, t); u != nullptr) {
    const c3::Solution& solution = c3_.solution();
    for (const Eigen::MatrixXd* copy : {&solution.z, &solution.delta}) {
      consider(horizon::modes(
          problem, horizon::roll_out(problem, copy->middleRows(sizes_.n_x, sizes_.n_lambda),
                                     copy->middleRows(sizes_.n_x + sizes_.n_lambda, sizes_.n_u))));
    }
    const lcs::Simulation simulation = lcs::simulate(lcs, problem.x0, *u);
    if (simulation.report.ok())
      consider(horizon::modes(problem, horizon::roll_out(problem, simulation.lambda, *u)));
  }
  if (!last_.empty()) {  // the last stage keeps its modes
    std::vector<horizon::Side> shifted(last_.begin() + sizes_.n_lambda, last_.end());
    shifted.insert(shifted.end(), last_.end() - sizes_.n_lambda, last_.end());
    consider(shifted);
  }
  return best;
}

const Eigen::MatrixXd* ExactController::decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x,
                                               double t) {
  end_ = seconds_now() + limit_;
  const horizon::Problem problem{sizes_,
                                 {&lcs, 0},
                                 &experiment_.costs,
                                 &experiment_.constraints,
                                 experiment_.x_desired.replicate(1, sizes_.N + 1),
                                 x};
  const horizon::SearchResult result =
      horizon::search(problem, {}, first_plan(problem, lcs, t), {&is_late, this});
  decisions_.push_back({result.plan ? result.gap : kNone, result.is_proven()});
  last_.clear();
  if (!result.plan) return nullptr;
  last_ = horizon::modes(problem, *result.plan);
  u_ = result.plan->u;
  return &u_;
}

}  // namespace c3rt::cli
