#include "cli/example/traced.hpp"

#include "cli/progress.hpp"
#include "cli/report/series.hpp"

namespace c3rt::cli {

example::Experiment traced(example::Experiment experiment) {
  experiment.c3.trace = true;
  return experiment;
}

TracedController::TracedController(const example::Experiment& experiment,
                                   const example::C3Controller& c3, example::Controller& decider)
    : c3_(c3),
      decider_(decider),
      projection_(c3::make_projection(example::sizes(experiment), experiment.c3)),
      rho_scale_(experiment.c3.rho_scale) {
  projection_->set_weights(experiment.costs);
}

const Eigen::MatrixXd* TracedController::decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x,
                                                double t) {
  const Eigen::MatrixXd* inputs = decider_.decide(lcs, x, t);
  projections_.push_back(inputs == nullptr ? ProjectionTimes{kNone, 0} : rehearse(lcs));
  if (projections_.size() == 1) {
    first_iterates_ = c3_.solution().trace;
    first_system_ = lcs;
  }
  return inputs;
}

ProjectionTimes TracedController::rehearse(const lcs::Lcs& lcs) {
  const c3::Solution& solution = c3_.solution();
  projection_->start(lcs);
  double total = 0.0;
  int count = 0, not_solved = 0;
  for (int i = 0; i < solution.iterations; ++i) {
    const c3::Iterate& iterate = solution.trace[static_cast<std::size_t>(i)];
    if (iterate.projections == 0) continue;
    // w was z + w − δ before it was divided by ρ_s
    const Eigen::MatrixXd v = rho_scale_ * iterate.w + iterate.delta;
    delta_ = v;
    const double start = seconds_now();
    for (int k = 0; k < iterate.projections; ++k) {
      const c3::ProjectionReport report = projection_->project(v.col(k), delta_.col(k), {});
      not_solved += report.status != c3::ProjectionStatus::kSolved ? 1 : 0;
    }
    total += seconds_now() - start;
    count += iterate.projections;
  }
  return {count > 0 ? total / count : kNone, not_solved};
}

}  // namespace c3rt::cli
