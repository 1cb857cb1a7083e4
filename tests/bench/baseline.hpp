#pragma once
// What the paper's tables time: OSQP with its default tolerances, set up anew for every QP, and the
// projection as a big-M problem (M = 1000) of a general MIQP solver, in one thread.
#include <memory>
#include <optional>
#include <string>

#include "controller/c3/projection.hpp"
#include "controller/qp/qp.hpp"
#include "tests/bench/problems.hpp"

namespace bench {

/// CPU time of this thread [s].
double thread_seconds();

/// One solve in the paper's configuration.
struct PaperTime {
  double qp, projections;  // [s]
  int timed_projections;   // of these the mean was taken
  double seconds() const { return qp + projections; }
};

/// Whether a general MIQP solver was found when this was built.
bool has_miqp_solver();

/// nullptr where there is no general MIQP solver.
std::unique_ptr<c3rt::c3::Projection> make_paper_projection(const c3rt::c3::Sizes& sizes);

/// A new OSQP with its own default settings.
std::unique_ptr<c3rt::qp::QpStep> make_paper_qp(const c3rt::c3::Sizes& sizes);

/// General MIQP solvers take up to seconds for one projection: of those of a problem at most this
/// many are timed, evenly spread, and no more once this time has gone by [s].
constexpr int kTimedProjections = 40;
constexpr double kTimedSeconds = 2.0;

/// Mean time of the paper's projection of columns of v. Needs a general MIQP solver.
double paper_projection_time(const Problem& problem, const State& state, const Eigen::MatrixXd& v);

/// Algorithm 1 in that configuration, the same QPs and rounds of projections as c3::Solver. Every
/// QP is timed; of the projections at most kTimedProjections, evenly spread: the others are
/// answered by our exact one and count with the mean. Each problem is timed once in a run of the
/// program. Nothing where there is no general MIQP solver.
std::optional<PaperTime> paper_solve_time(const Problem& problem);

}  // namespace bench
