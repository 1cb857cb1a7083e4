// What the benchmarks time is solved: the published tasks, each with every projection they time.
#include "tests/bench/problems.hpp"

#include <catch2/catch.hpp>

#include "controller/c3/solver.hpp"

using namespace c3rt;
using c3::ProjectionKind;
using c3::QpBackend;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The first QP of Algorithm 1 with the weights G, by this back end.
qp::QpReport first_qp(const bench::Problem& p, const bench::State& at, QpBackend backend) {
  const auto qp = backend == QpBackend::kDirect ? qp::make_direct_qp(p.sizes)
                                                : qp::make_interior_point_qp(p.sizes);
  c3::Constraints constraints = p.constraints;
  if (backend == QpBackend::kInteriorPoint && !c3::any(constraints)) {
    constraints.u_max = VectorXd::Constant(p.sizes.n_u, 1e6);  // nothing comes near it
  }
  qp->set_costs(p.costs, constraints);
  qp->start({&at.lcs, 0}, {p.costs.G.data(), 0}, nullptr);
  MatrixXd start = MatrixXd::Zero(p.sizes.n_z(), p.sizes.N);
  if (p.settings.delta_starts_at_x0) start.topRows(p.sizes.n_x).colwise() = at.x0;
  MatrixXd z = start;
  VectorXd x_N = at.x0;
  return qp->solve(p.settings.rho, at.x0, p.x_desired(at), p.costs.G[0] * start, z, x_N);
}

}  // namespace

TEST_CASE("benchmarks: the first QP of every problem is solved, by every back end that takes it") {
  for (const char* name : {"cart_pole", "gaiting", "pivoting", "1_ball", "2_balls", "3_balls"}) {
    for (const int N : {5, 10, 50}) {
      const bench::Problem p = bench::problem(name, ProjectionKind::kMiqp, N);
      for (std::size_t i = 0; i < p.states.size(); ++i) {
        for (const QpBackend backend : {QpBackend::kDirect, QpBackend::kInteriorPoint}) {
          if (backend == QpBackend::kDirect && c3::any(p.constraints)) continue;
          const qp::QpReport report = first_qp(p, p.states[i], backend);
          CAPTURE(name, N, i, static_cast<int>(backend), report.iterations, report.primal_residual,
                  report.dual_residual);
          CHECK(report.status == qp::QpStatus::kSolved);
        }
      }
    }
  }
}

TEST_CASE("benchmarks: every problem is solved with every projection that takes a fixed time") {
  struct Timed {
    const char* problem;
    std::vector<ProjectionKind> kinds;
  };
  const Timed all[] = {{"cart_pole",
                        {ProjectionKind::kLcp, ProjectionKind::kAdmm, ProjectionKind::kConvex,
                         ProjectionKind::kPlus}},
                       {"gaiting", {ProjectionKind::kAdmm, ProjectionKind::kPlus}},
                       {"pivoting", {ProjectionKind::kAdmm, ProjectionKind::kPlus}},
                       {"1_ball", {ProjectionKind::kConvex, ProjectionKind::kPlus}},
                       {"2_balls", {ProjectionKind::kPlus}},
                       {"3_balls", {ProjectionKind::kConvex, ProjectionKind::kPlus}}};
  for (const Timed& timed : all) {
    for (const ProjectionKind kind : timed.kinds) {
      for (const int N : {5, 50}) {
        const bench::Problem p = bench::problem(timed.problem, kind, N);
        c3::Solver solver(p.sizes, p.settings);
        solver.set_costs(p.costs, p.constraints);
        for (std::size_t i = 0; i < p.states.size(); ++i) {
          const bench::State& at = p.states[i];
          const c3::Solution& solution = solver.solve(at.lcs, at.x0, p.x_desired(at));
          CAPTURE(timed.problem, static_cast<int>(kind), N, i, solution.iterations,
                  static_cast<int>(solution.failure), static_cast<int>(solution.qp.status),
                  solution.qp.iterations, solution.qp.primal_residual, solution.qp.dual_residual);
          CHECK(solution.status == c3::SolveStatus::kOk);
        }
      }
    }
  }
}
