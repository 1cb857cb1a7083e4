#include "tests/controller/c3/golden.hpp"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A minimiser is compared elementwise only where the next best mode is this much worse.
constexpr double kMargin = 1e-5;

double distance(const MatrixXd& a, const MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / std::max(1.0, b.cwiseAbs().maxCoeff());
}

/// w that iteration i of the reference started from.
MatrixXd dual(const golden::Case& c, std::size_t i) {
  MatrixXd w = MatrixXd::Zero(c.sizes.n_z(), c.sizes.N);
  for (std::size_t j = 0; j < i; ++j) {
    w = (w + c.iterations[j].z - c.iterations[j].delta) / c.rho_scale;
  }
  return w;
}

MatrixXd first_delta(const golden::Case& c) {
  MatrixXd delta = MatrixXd::Zero(c.sizes.n_z(), c.sizes.N);
  if (c.delta_starts_at_x0) delta.topRows(c.sizes.n_x).colwise() = c.x0;
  return delta;
}

/// λ_0 that the reference fixed, where it did.
VectorXd first_lambda(const golden::Case& c) {
  c3rt::lcs::Lemke lemke(c.sizes.n_lambda);
  VectorXd lambda(c.sizes.n_lambda);
  REQUIRE(lemke.solve(c.lcs.F, VectorXd(c.lcs.E * c.x0 + c.lcs.c), lambda).status ==
          c3rt::lcs::LcpStatus::kSolved);
  return lambda;
}

void compare_qp(const golden::Case& c, QpStep& qp, double tolerance) {
  qp.set_costs(c.costs, c.bounds);
  const VectorXd lambda_0 = c.fixes_lambda_0 ? first_lambda(c) : VectorXd();
  qp.start({&c.lcs, 0}, {c.costs.G.data(), 0}, c.fixes_lambda_0 ? &lambda_0 : nullptr);
  MatrixXd z(c.sizes.n_z(), c.sizes.N);
  VectorXd x_N(c.sizes.n_x);
  for (std::size_t i = 0; i < c.iterations.size(); ++i) {
    const MatrixXd delta = i == 0 ? first_delta(c) : c.iterations[i - 1].delta;
    const QpReport report = qp.solve(c.iterations[i].rho, c.x0, c.x_desired,
                                     c.costs.G[0] * (delta - dual(c, i)), z, x_N);
    CAPTURE(c.id, i, report.iterations, report.dual_residual);
    CHECK(report.status == QpStatus::kSolved);
    CHECK(distance(z, c.iterations[i].z) < tolerance);
    CHECK(distance(x_N, c.iterations[i].x_N) < tolerance);
  }
}

}  // namespace

TEST_CASE("golden: the direct QP step is the reference's, from the same delta and w") {
  int compared = 0;
  for (const char* example : {"cartpole", "pivoting"}) {
    for (const golden::Case& c : golden::load(example)) {
      if (c.bounded) continue;
      compare_qp(c, *make_direct_qp(c.sizes), 1e-8);
      ++compared;
    }
  }
  REQUIRE(compared >= 38);
}

TEST_CASE("golden: the interior point's QP step is the reference's, with and without bounds") {
  int compared = 0;
  for (const char* example : {"cartpole", "finger", "pivoting"}) {
    for (const golden::Case& c : golden::load(example)) {
      compare_qp(c, *make_interior_point_qp(c.sizes), 1e-6);
      ++compared;
    }
  }
  REQUIRE(compared >= 50);
}

TEST_CASE("golden: the OSQP step is the reference's, with and without bounds") {
  int compared = 0;
  for (const char* example : {"cartpole", "finger", "pivoting"}) {
    for (const golden::Case& c : golden::load(example)) {
      compare_qp(c, *make_osqp_qp(c.sizes, c.settings(QpBackend::kOsqp).osqp), 1e-6);
      ++compared;
    }
  }
  REQUIRE(compared >= 50);
}

TEST_CASE("golden: the MIQP projection is the reference's, from the same z and w") {
  int unique = 0, all = 0;
  for (const char* example : {"cartpole", "finger", "pivoting"}) {
    for (const golden::Case& c : golden::load(example)) {
      if (c.projection != "MIQP") continue;
      const auto projection = make_miqp_projection(c.sizes, 1 << 12);
      projection->set_weights(c.costs);
      projection->start(c.lcs);
      VectorXd delta(c.sizes.n_z());
      for (std::size_t i = 0; i < c.iterations.size(); ++i) {
        const golden::Iteration& reference = c.iterations[i];
        const MatrixXd v = reference.z + dual(c, i);
        for (int k = 0; k < c.sizes.N; ++k) {
          const ProjectionReport report = projection->project(v.col(k), delta, {});
          CAPTURE(c.id, i, k, report.nodes, reference.margin[k]);
          CHECK(report.status == ProjectionStatus::kSolved);
          // the kept digits of z (12) limit what can be asked of small objectives
          CHECK(report.objective == Approx(reference.objective[k]).epsilon(1e-7).margin(1e-8));
          ++all;
          if (reference.margin[k] < kMargin) continue;
          CHECK(distance(delta, reference.delta.col(k)) < 1e-6);
          ++unique;
        }
      }
    }
  }
  REQUIRE(all >= 100);
  REQUIRE(2 * unique > all);
}

TEST_CASE("golden: the LCP projection is the reference's, from the same z and w") {
  int unique = 0;
  for (const char* example : {"cartpole", "finger"}) {
    for (const golden::Case& c : golden::load(example)) {
      if (c.projection != "LCP") continue;
      const auto projection = make_lcp_projection(c.sizes);
      projection->set_weights(c.costs);
      projection->start(c.lcs);
      VectorXd delta(c.sizes.n_z());
      for (std::size_t i = 0; i < c.iterations.size(); ++i) {
        const golden::Iteration& reference = c.iterations[i];
        const MatrixXd v = reference.z + dual(c, i);
        for (int k = 0; k < c.sizes.N; ++k) {
          const ProjectionReport report = projection->project(v.col(k), delta, {});
          CAPTURE(c.id, i, k);
          CHECK(report.status == ProjectionStatus::kSolved);
          const VectorXd y = c.lcs.E * c.sizes.x(delta) + c.lcs.F * c.sizes.lambda(delta) +
                             c.lcs.H * c.sizes.u(delta) + c.lcs.c;
          CHECK(y.cwiseMin(c.sizes.lambda(delta)).cwiseAbs().maxCoeff() < 1e-9);
          if (!reference.unique_lambda) continue;
          CHECK(distance(delta, reference.delta.col(k)) < 1e-8);
          ++unique;
        }
      }
    }
  }
  REQUIRE(unique >= 50);
}

TEST_CASE("golden: the convex projection is the reference's, from the same z and w") {
  int compared = 0;
  for (const golden::Case& c : golden::load("cartpole")) {
    if (c.projection != "CONVEX") continue;
    const auto projection = make_convex_projection(c.sizes);
    projection->set_weights(c.costs);
    projection->start(c.lcs);
    VectorXd delta(c.sizes.n_z());
    for (std::size_t i = 0; i < c.iterations.size(); ++i) {
      const MatrixXd v = c.iterations[i].z + dual(c, i);
      for (int k = 0; k < c.sizes.N; ++k) {
        const ProjectionReport report = projection->project(v.col(k), delta, {});
        CAPTURE(c.id, i, k);
        CHECK(report.status == ProjectionStatus::kSolved);
        CHECK(distance(delta, c.iterations[i].delta.col(k)) < 1e-8);
        ++compared;
      }
    }
  }
  REQUIRE(compared >= 100);
}

TEST_CASE("golden: a whole solve is the reference's, iterate by iterate") {
  int compared = 0, unique_throughout = 0;
  for (const char* example : {"cartpole", "finger", "pivoting"}) {
    for (const golden::Case& c : golden::load(example)) {
      for (const QpBackend backend :
           {QpBackend::kDirect, QpBackend::kInteriorPoint, QpBackend::kOsqp}) {
        if (backend == QpBackend::kDirect && c.bounded) continue;
        Solver solver(c.sizes, c.settings(backend));
        solver.set_costs(c.costs, c.bounds);
        const Solution& solution = solver.solve(c.lcs, c.x0, c.x_desired);
        CAPTURE(c.id, static_cast<int>(backend));
        CHECK(solution.status == SolveStatus::kOk);
        CHECK(solution.iterations == c.s);
        CHECK(solution.projections == c.s);
        bool unique = true;
        for (int i = 0; i < c.s; ++i) {
          const golden::Iteration& reference = c.iterations[i];
          const Iterate& iterate = solution.trace[i];
          CAPTURE(i);
          CHECK(iterate.rho == Approx(reference.rho));
          CHECK(distance(iterate.z, reference.z) < 1e-5);
          CHECK(distance(iterate.x_N, reference.x_N) < 1e-5);
          ++compared;
          // a choice between equal modes makes another, equally right, path from here on
          unique = unique && reference.unique_lambda && reference.margin.minCoeff() > kMargin;
          if (!unique) break;
          CHECK(distance(iterate.delta, reference.delta) < 1e-5);
          CHECK(distance(iterate.w, dual(c, static_cast<std::size_t>(i) + 1)) < 1e-5);
        }
        if (!unique) continue;
        CHECK(distance(solution.u_0(), c.u_0) < 1e-5);
        ++unique_throughout;
      }
    }
  }
  REQUIRE(compared >= 500);
  REQUIRE(unique_throughout >= 60);
}
