#include "tests/bench/baseline.hpp"

#include <ctime>
#include <map>

#ifdef C3RT_HAS_MIQP
#include "controller/miqp/big_m_projection.hpp"
#endif

namespace bench {
namespace {

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class Stopwatch {
 public:
  void start() { start_ = thread_seconds(); }
  void stop() { seconds_ += thread_seconds() - start_; }
  double seconds() const { return seconds_; }

 private:
  double start_ = 0.0, seconds_ = 0.0;
};

/// Algorithm 1, written down as it stands.
PaperTime paper_solve(const Problem& p, const State& state) {
  const c3::Sizes& sizes = p.sizes;
  const MatrixXd x_desired = p.x_desired(state);
  MatrixXd z = MatrixXd::Zero(sizes.n_z(), sizes.N), delta = z, w = z, g = z;
  VectorXd x_N = VectorXd::Zero(sizes.n_x), copy(sizes.n_z());
  if (p.settings.delta_starts_at_x0) delta.topRows(sizes.n_x).colwise() = state.x0;
  const auto paper = make_paper_projection(sizes);
  const auto ours = c3::make_miqp_projection(sizes, p.settings.max_nodes);
  for (c3::Projection* projection : {paper.get(), ours.get()}) {
    projection->set_weights(p.costs);
    projection->start(state.lcs);
  }

  const int all = (p.settings.admm_iterations - 1) * sizes.N;
  const int step = (all + kTimedProjections - 1) / kTimedProjections;
  int index = 0, timed = 0;
  Stopwatch qps, projections;
  double rho = p.settings.rho;
  for (int i = 0; i < p.settings.admm_iterations; ++i) {
    g.noalias() = p.costs.G[0] * (delta - w);
    qps.start();
    const auto qp = make_paper_qp(sizes);
    qp->set_costs(p.costs, p.constraints);
    qp->start({&state.lcs, 0}, {p.costs.G.data(), 0}, nullptr);
    (void)qp->solve(rho, state.x0, x_desired, g, z, x_N);
    qps.stop();
    if (i + 1 == p.settings.admm_iterations) break;
    for (int k = 0; k < sizes.N; ++k) {
      if (index++ % step == 0 && projections.seconds() < kTimedSeconds) {
        projections.start();
        (void)paper->project(z.col(k) + w.col(k), copy, {});
        projections.stop();
        ++timed;
      } else {
        (void)ours->project(z.col(k) + w.col(k), copy, {});
      }
      delta.col(k) = copy;
    }
    w = (w + z - delta) / p.settings.rho_scale;
    rho *= p.settings.rho_scale;
  }
  return {qps.seconds(), projections.seconds() * all / timed, timed};
}

}  // namespace

double thread_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

#ifdef C3RT_HAS_MIQP
bool has_miqp_solver() { return true; }
std::unique_ptr<c3::Projection> make_paper_projection(const c3::Sizes& sizes) {
  return miqp::make_big_m_projection(sizes, 1000.0, {});
}
#else
bool has_miqp_solver() { return false; }
std::unique_ptr<c3::Projection> make_paper_projection(const c3::Sizes&) { return nullptr; }
#endif

std::unique_ptr<qp::QpStep> make_paper_qp(const c3::Sizes& sizes) {
  return qp::make_osqp_qp(sizes, {4000, 1e-3, 0.1, 100, false});
}

double paper_projection_time(const Problem& problem, const State& state, const MatrixXd& v) {
  const auto projection = make_paper_projection(problem.sizes);
  projection->set_weights(problem.costs);
  projection->start(state.lcs);
  VectorXd delta(v.rows());
  const Eigen::Index step = (v.cols() + kTimedProjections - 1) / kTimedProjections;
  int timed = 0;
  const double start = thread_seconds();
  double seconds = 0.0;
  for (Eigen::Index k = 0; k < v.cols() && seconds < kTimedSeconds; k += step, ++timed) {
    (void)projection->project(v.col(k), delta, {});
    seconds = thread_seconds() - start;
  }
  return seconds / timed;
}

std::optional<PaperTime> paper_solve_time(const Problem& problem) {
  if (!has_miqp_solver()) return std::nullopt;
  static std::map<std::pair<std::string, int>, PaperTime> timed;
  const auto key = std::pair(problem.name, problem.sizes.N);
  const auto found = timed.find(key);
  if (found != timed.end()) return found->second;
  return timed[key] = paper_solve(problem, problem.states[5]);
}

}  // namespace bench
