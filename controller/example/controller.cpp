#include "controller/example/controller.hpp"

#include <cmath>

namespace c3rt::example {
namespace {

/// What is carried over to the next step is the result of all s projections.
c3::Settings solver_settings(const Experiment& experiment) {
  c3::Settings settings = experiment.c3;
  settings.project_last = settings.project_last || experiment.start != StartPolicy::kFresh;
  return settings;
}

}  // namespace

C3Controller::C3Controller(const Experiment& experiment)
    : policy_(experiment.start),
      reset_period_(experiment.start_reset_period),
      sizes_(sizes(experiment)),
      rho_(experiment.c3.rho),
      solver_(sizes_, solver_settings(experiment)),
      x_desired_(experiment.x_desired.replicate(1, sizes_.N + 1)),
      u_(sizes_.n_u, sizes_.N),
      known_(experiment.control_period, experiment.planning_step, sizes_.N) {
  solver_.set_costs(experiment.costs, experiment.constraints);
  start_.delta.setZero(solver_.n_copy(), sizes_.N);
  start_.w.setZero(solver_.n_copy(), sizes_.N);
}

void C3Controller::reset() {
  has_start_ = false;
  known_.forget();
  period_ = 0;
}

const Eigen::MatrixXd* C3Controller::decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x,
                                            double t) {
  // the published loop forgets the copies at every multiple of the period, also between two calls
  if (policy_ == StartPolicy::kCarriedForces && reset_period_ > 0.0) {
    const auto period = static_cast<long>(std::floor(t / reset_period_ + 1e-9));
    if (period != period_) has_start_ = false;
    period_ = period;
  }
  if (has_start_ && policy_ == StartPolicy::kCarriedForces) {
    start_.delta.topRows(sizes_.n_x).colwise() = x;
  }
  const bool started = has_start_ && policy_ != StartPolicy::kFresh;
  c3::KnownPlan::put(known_.start(), start_);
  const c3::Start* start = started ? &start_ : known_.start();
  solution_ = &solver_.solve(lcs, x, x_desired_, {}, start);
  known_.keep(*solution_);
  if (solution_->status == c3::SolveStatus::kFailed) {
    has_start_ = false;
    return nullptr;
  }
  if (policy_ == StartPolicy::kCarriedForces) {
    start_.delta = solution_->delta;
    start_.w.setZero();
  } else if (policy_ == StartPolicy::kShifted) {
    shift(*solution_, rho_, start_);
  }
  has_start_ = true;
  u_ = solution_->z.middleRows(sizes_.n_x + sizes_.n_lambda, sizes_.n_u);
  return &u_;
}

}  // namespace c3rt::example
