// The QP steps against truths that are known by construction or found densely in long double: what
// an answer says it is, it is.
#include <cmath>
#include <memory>
#include <string>

#include <Eigen/LU>
#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "controller/qp/qp.hpp"
#include "tests/controller/qp/qp_problem.hpp"
#include "tests/support/property.hpp"

using namespace c3rt;
using namespace c3rt::qp;
using namespace qp_problem;

namespace {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

const OsqpSettings kOsqp{20000, 1e-8, 0.1, 50, true};

/// Random sizes, systems and weights, one system for all stages. Inputs and forces are few, so that
/// much of the state is out of their reach.
Problem some_problem(support::Random& random, int longest) {
  const Sizes s{1 + random.index(4), random.index(3), 1 + random.index(2),
                1 + random.index(longest)};
  lcs::Lcs lcs{random.matrix(s.n_x, s.n_x),      random.matrix(s.n_x, s.n_u),
               random.matrix(s.n_x, s.n_lambda), random.vector(s.n_x),
               random.matrix(s.n_lambda, s.n_x), random.matrix(s.n_lambda, s.n_lambda),
               random.matrix(s.n_lambda, s.n_u), random.vector(s.n_lambda)};
  for (MatrixXd* m : {&lcs.A, &lcs.B, &lcs.D}) {
    for (Eigen::Index i = 0; i < m->size(); ++i) {
      if (random.index(3) == 0) m->data()[i] = 0.0;
    }
  }
  Problem p{s,
            std::vector<lcs::Lcs>(s.N, lcs),
            {},
            {},
            0.3,
            random.vector(s.n_x),
            random.matrix(s.n_x, s.N + 1),
            {}};
  p.costs = {definite(random, s.n_x),
             definite(random, s.n_x),
             definite(random, s.n_u),
             definite(random, s.n_z()),
             {}};
  consensus(p, random.matrix(s.n_z(), s.N));
  return p;
}

/// Where these inputs lead.
Answer roll_out(const Problem& p, const MatrixXd& nu) {
  Answer a{{}, MatrixXd(p.sizes.n_z(), p.sizes.N), p.x0};
  a.z.bottomRows(nu.rows()) = nu;
  for (int k = 0; k < p.sizes.N; ++k) {
    p.sizes.x(a.z.col(k)) = a.x_N;
    a.x_N = p.lcs[k].A * a.x_N + p.lcs[k].B * p.sizes.u(a.z.col(k)) +
            p.lcs[k].D * p.sizes.lambda(a.z.col(k)) + p.lcs[k].d;
  }
  return a;
}

enum class Truth { kFeasible, kInfeasible, kUnclear };

/// By least squares in long double over all inputs: whether the rows, all of them equalities, can
/// hold at once.
Truth equalities(const Problem& p) {
  const Sizes& s = p.sizes;
  const int n_nu = s.n_lambda + s.n_u, n_z = s.n_z(), n = s.N * n_z + s.n_x;
  LongMatrix Phi = LongMatrix::Zero(n, s.N * n_nu);
  const Answer rest = roll_out(p, MatrixXd::Zero(n_nu, s.N));
  for (int k = 0; k < s.N; ++k) {
    MatrixXd step(s.n_x, n_z);
    step << p.lcs[k].A, p.lcs[k].D, p.lcs[k].B;
    Phi.block(k * n_z + s.n_x, k * n_nu, n_nu, n_nu).setIdentity();
    Phi.middleRows((k + 1) * n_z, s.n_x) = step.cast<long double>() * Phi.middleRows(k * n_z, n_z);
  }
  VectorXd at_rest(n);
  at_rest << rest.z.reshaped(), rest.x_N;
  const std::vector<Row> all = rows(p);
  LongMatrix C(all.size(), Phi.cols());
  LongVector b(all.size());
  long double size = 1.0L;
  for (std::size_t i = 0; i < all.size(); ++i) {
    C.row(i) = all[i].a.transpose().cast<long double>() * Phi;
    b[i] = all[i].lower - all[i].a.dot(at_rest);
    size = std::max(size, std::abs(static_cast<long double>(all[i].lower)));
  }
  const LongVector nu = C.colPivHouseholderQr().solve(b);
  const long double missed = b.size() == 0 ? 0.0L : (C * nu - b).cwiseAbs().maxCoeff();
  // what needs inputs of a thousand is neither
  if (nu.size() > 0 && nu.cwiseAbs().maxCoeff() > 1e3L) return Truth::kUnclear;
  if (missed < 1e-11L * size) return Truth::kFeasible;
  return missed > 1e-5L * size ? Truth::kInfeasible : Truth::kUnclear;
}

/// An answer that is called solved meets dynamics and rows and is the KKT system's.
void check_solved(const Problem& p, const Answer& answer, double tolerance) {
  const Reference expected = reference(p, &answer);
  CHECK(error(p, answer, expected) < tolerance);
  CHECK(expected.wrong < tolerance);
}

struct Named {
  const char* name;
  std::unique_ptr<QpStep> qp;
  double tolerance;
};

std::vector<Named> constrained_steps(const Sizes& sizes) {
  std::vector<Named> all;
  all.push_back({"interior point", make_interior_point_qp(sizes), 1e-6});
  all.push_back({"OSQP", make_osqp_qp(sizes, kOsqp), 1e-4});
  return all;
}

void fix(VectorXd& lower, VectorXd& upper, Eigen::Index size) {
  if (lower.size() == 0) {
    lower = VectorXd::Constant(size, -kNone);
    upper = VectorXd::Constant(size, kNone);
  }
}

}  // namespace

TEST_CASE(
    "QP steps: equalities that can be met are, redundant ones too, and others are infeasible") {
  int counts[3] = {0, 0, 0}, solved[2] = {0, 0}, unsolved = 0;
  for (int seed = 0; seed < test::property_instances(); ++seed) {
    support::Random random(static_cast<unsigned>(seed));
    Problem p = some_problem(random, 5);
    const Sizes& s = p.sizes;
    const Answer point = roll_out(p, random.matrix(s.n_lambda + s.n_u, s.N));
    Constraints& c = p.constraints;
    fix(c.x_N_min, c.x_N_max, s.n_x);
    // states where the point's are, more of them than can be chosen freely
    for (int i = 0; i < s.n_x; ++i) {
      if (random.index(3) > 0) c.x_N_min[i] = c.x_N_max[i] = point.x_N[i];
    }
    // a row twice, in other units, with the same bound or another
    const int kind = random.index(4);
    if (kind <= 1) {
      const double unit = std::pow(10.0, random.uniform(-3.0, 3.0));
      MatrixXd C(2, s.n_z());
      C.row(0) = random.matrix(1, s.n_z());
      C.row(1) = -unit * C.row(0);
      std::vector<VectorXd> value(s.N);
      for (int k = 0; k < s.N; ++k) {
        value[k] = C * point.z.col(k);
        if (kind == 1 && k == s.N - 1) value[k][1] += unit * random.uniform(0.01, 1.0);
      }
      c.C = C;
      c.C_min = value;
      c.C_max = value;
    }
    // an end that is elsewhere, perhaps out of reach
    if (kind == 2) {
      const int i = random.index(s.n_x);
      c.x_N_min[i] = c.x_N_max[i] = point.x_N[i] + random.uniform();
    }
    const Truth truth = equalities(p);
    ++counts[static_cast<int>(truth)];
    if (truth == Truth::kUnclear) continue;
    int step = 0;
    for (const Named& named : constrained_steps(s)) {
      const Answer answer = solve(*named.qp, p);
      CAPTURE(seed, named.name, kind, static_cast<int>(truth),
              static_cast<int>(answer.report.status), answer.report.iterations,
              answer.report.primal_residual, answer.report.dual_residual);
      if (truth == Truth::kFeasible) {
        CHECK(answer.report.status != QpStatus::kInfeasible);
        unsolved += answer.report.status != QpStatus::kSolved;
      } else {
        CHECK(answer.report.status == QpStatus::kInfeasible);
      }
      if (answer.report.status == QpStatus::kSolved) check_solved(p, answer, named.tolerance);
      solved[step++] += answer.report.status == QpStatus::kSolved;
    }
  }
  CAPTURE(counts[0], counts[1], counts[2], solved[0], solved[1], unsolved);
  // rows a thousandfold apart that all but contradict each other may end as "not converged"
  CHECK(unsolved <= test::property_instances() / 500);
  CHECK(counts[0] > test::property_instances() / 4);
  CHECK(counts[1] > test::property_instances() / 10);
}

TEST_CASE("QP steps: an end just inside or just outside of what bounded inputs reach") {
  for (int seed = 0; seed < test::property_instances(); ++seed) {
    support::Random random(static_cast<unsigned>(seed));
    Problem p = some_problem(random, 6);
    const Sizes& s = p.sizes;
    const int n_nu = s.n_lambda + s.n_u, i = random.index(s.n_x);
    // the farthest that x_N,i gets is the sum of what each input does at its bound
    const double limit = std::pow(10.0, random.uniform(-1.0, 2.0));
    double farthest = roll_out(p, MatrixXd::Zero(n_nu, s.N)).x_N[i], reach = 0.0;
    VectorXd adjoint = VectorXd::Unit(s.n_x, i);
    for (int k = s.N - 1; k >= 0; --k) {
      reach += limit * (p.lcs[k].B.transpose() * adjoint).cwiseAbs().sum();
      if (s.n_lambda > 0) reach += limit * (p.lcs[k].D.transpose() * adjoint).cwiseAbs().sum();
      adjoint = p.lcs[k].A.transpose() * adjoint;
    }
    const double margin = std::pow(10.0, random.uniform(-4.0, 0.0));
    const bool inside = random.index(2) == 0;
    if (inside && reach < 1e-3) continue;
    farthest += inside ? reach * (1.0 - margin) : reach + margin * std::max(reach, 0.1);
    Constraints& c = p.constraints;
    c.u_max = VectorXd::Constant(s.n_u, limit);
    c.u_min = VectorXd::Constant(s.n_u, -limit);
    c.lambda_max = VectorXd::Constant(s.n_lambda, limit);
    c.lambda_min = VectorXd::Constant(s.n_lambda, -limit);
    c.x_N_min = VectorXd::Constant(s.n_x, -kNone);
    c.x_N_min[i] = farthest;
    for (const Named& named : constrained_steps(s)) {
      const Answer answer = solve(*named.qp, p);
      CAPTURE(seed, named.name, inside, margin, limit, static_cast<int>(answer.report.status),
              answer.report.iterations, answer.report.primal_residual, answer.report.dual_residual);
      CHECK(answer.report.status == (inside ? QpStatus::kSolved : QpStatus::kInfeasible));
      if (answer.report.status == QpStatus::kSolved) check_solved(p, answer, named.tolerance);
    }
  }
}

namespace {

/// An unstable system: modes of up to `radius`, some stable, some of them defective, in a random
/// basis.
Problem unstable(support::Random& random, double radius, int N, bool controllable) {
  const Sizes s{1 + random.index(3), random.index(2), 1 + random.index(2), N};
  MatrixXd J = MatrixXd::Zero(s.n_x, s.n_x);
  for (int i = 0; i < s.n_x; ++i) {
    const int kind = random.index(3);
    const bool repeats = i > 0 && kind == 0;
    J(i, i) = repeats ? J(i - 1, i - 1) : kind == 1 ? random.uniform() : radius * random.uniform();
    if (repeats) J(i - 1, i) = 1.0;
  }
  if (std::abs(J(0, 0)) < 1.0) J(0, 0) = radius;
  MatrixXd basis = random.matrix(s.n_x, s.n_x);
  basis.diagonal().array() += 2.0;
  const MatrixXd inverse = basis.inverse();
  lcs::Lcs lcs{basis * J * inverse,
               random.matrix(s.n_x, s.n_u),
               0.1 * random.matrix(s.n_x, s.n_lambda),
               0.1 * random.vector(s.n_x),
               random.matrix(s.n_lambda, s.n_x),
               MatrixXd::Identity(s.n_lambda, s.n_lambda),
               MatrixXd::Zero(s.n_lambda, s.n_u),
               random.vector(s.n_lambda)};
  if (!controllable) {  // the first mode is out of every input's reach
    MatrixXd B = inverse * lcs.B, D = inverse * lcs.D;
    B.row(0).setZero();
    D.row(0).setZero();
    J.row(0).tail(s.n_x - 1).setZero();
    lcs.A = basis * J * inverse;
    lcs.B = basis * B;
    lcs.D = basis * D;
  }
  Problem p{s,
            std::vector<lcs::Lcs>(s.N, lcs),
            {},
            {},
            0.1,
            random.vector(s.n_x),
            0.1 * random.matrix(s.n_x, s.N + 1),
            {}};
  p.costs = {definite(random, s.n_x),
             definite(random, s.n_x),
             definite(random, s.n_u),
             definite(random, s.n_z()),
             {}};
  consensus(p, 0.1 * random.matrix(s.n_z(), s.N));
  return p;
}

}  // namespace

TEST_CASE("QP steps: unstable systems over long horizons are the KKT system's solution") {
  int ok = 0, all = 0;
  for (int seed = 0; seed < test::property_instances(); ++seed) {
    support::Random random(static_cast<unsigned>(seed));
    const double radii[] = {1.1, 1.5, 2.0, 4.0, 10.0};
    const double radius = radii[random.index(5)];
    Problem p = unstable(random, radius, 10 + random.index(41), true);
    const Reference expected = reference(p);
    const Answer direct = solve(*make_direct_qp(p.sizes), p);
    const auto check = [&](const char* name, const Answer& answer, double tolerance) {
      CAPTURE(seed, name, radius, p.sizes.n_x, p.sizes.N, static_cast<int>(answer.report.status),
              answer.report.iterations, answer.report.primal_residual, answer.report.dual_residual);
      if (answer.report.status == QpStatus::kSolved) {
        CHECK(error(p, answer, expected) < tolerance);
      }
      ++all;
      ok += answer.report.status == QpStatus::kSolved;
    };
    check("direct", direct, 1e-9);
    // bounds that nothing comes near leave it as it is
    p.constraints.u_max = VectorXd::Constant(p.sizes.n_u, 1e6);
    check("interior point", solve(*make_interior_point_qp(p.sizes), p), 1e-7);
  }
  // a mode that the few inputs reach only through another may need more digits than there are
  CAPTURE(ok, all);
  CHECK(ok > all * 95 / 100);
}

TEST_CASE("QP steps: unstable systems with bounds that hold") {
  int ok = 0;
  for (int seed = 0; seed < test::property_instances(); ++seed) {
    support::Random random(static_cast<unsigned>(seed));
    const double radii[] = {1.1, 1.5, 2.0, 4.0};
    const double radius = radii[random.index(4)];
    Problem p = unstable(random, radius, 5 + random.index(16), true);
    const Answer free = solve(*make_direct_qp(p.sizes), p);
    if (free.report.status != QpStatus::kSolved) continue;
    // a state or an input a little less far than it would go
    const int k = 1 + random.index(p.sizes.N - 1);
    const int i = random.index(p.sizes.n_x);
    const double share = random.uniform(0.5, 1.0);
    if (random.index(2) == 0) {
      std::vector<VectorXd> x_max(p.sizes.N, VectorXd::Constant(p.sizes.n_x, kNone));
      x_max[k][i] = free.z(i, k) - (1.0 - share) * std::abs(free.z(i, k));
      p.constraints.x_max = x_max;
    } else {
      p.constraints.u_max = VectorXd::Constant(
          p.sizes.n_u, share * free.z.bottomRows(p.sizes.n_u).cwiseAbs().maxCoeff());
      p.constraints.u_min = -p.constraints.u_max[0];
    }
    const Answer answer = solve(*make_interior_point_qp(p.sizes), p);
    CAPTURE(seed, radius, p.sizes.n_x, p.sizes.N, static_cast<int>(answer.report.status),
            answer.report.iterations, answer.report.primal_residual, answer.report.dual_residual);
    if (answer.report.status == QpStatus::kSolved) check_solved(p, answer, 1e-6);
    ok += answer.report.status == QpStatus::kSolved;
  }
  CAPTURE(ok);
  CHECK(ok > test::property_instances() * 8 / 10);
}

TEST_CASE("QP steps: unstable modes out of reach never give a wrong answer that is called solved") {
  for (int seed = 0; seed < test::property_instances(); ++seed) {
    support::Random random(static_cast<unsigned>(seed));
    const double radii[] = {1.1, 2.0, 10.0};
    const double radius = radii[random.index(3)];
    Problem p = unstable(random, radius, 5 + random.index(46), false);
    const Reference expected = reference(p);
    const Answer answer = solve(*make_direct_qp(p.sizes), p);
    CAPTURE(seed, p.sizes.n_x, p.sizes.N, static_cast<int>(answer.report.status),
            answer.report.primal_residual, answer.report.dual_residual);
    if (answer.report.status != QpStatus::kSolved) continue;
    CHECK(error(p, answer, expected) < 1e-6);
    const VectorXd u_0 = p.sizes.u(answer.z.col(0)), expected_u_0 = p.sizes.u(expected.z.col(0));
    CHECK((u_0 - expected_u_0).norm() < 1e-5 * std::max(1.0, expected_u_0.norm()));
  }
}

TEST_CASE("QP steps: what OSQP calls solved or infeasible the interior point calls the same") {
  int solved = 0, failed = 0;
  for (int seed = 0; seed < test::property_instances(); ++seed) {
    support::Random random(static_cast<unsigned>(seed));
    Problem p = some_problem(random, 4);
    const Sizes& s = p.sizes;
    // units of rows and inputs far apart, the point far away
    const double far = std::pow(10.0, random.uniform(0.0, 3.0));
    const Answer point = roll_out(p, far * random.matrix(s.n_lambda + s.n_u, s.N));
    const int n_rows = 1 + random.index(3);
    MatrixXd C = random.matrix(n_rows, s.n_z());
    for (int row = 0; row < n_rows; ++row) C.row(row) *= std::pow(10.0, random.uniform(-2.0, 2.0));
    std::vector<VectorXd> lower(s.N), upper(s.N);
    for (int k = 0; k < s.N; ++k) {
      lower[k] = C * point.z.col(k);
      upper[k] = lower[k] + 0.1 * lower[k].cwiseAbs();
      if (random.index(8) == 0) {  // perhaps not to be met together
        lower[k][0] += far * random.uniform();
        upper[k][0] = lower[k][0] + 1e-3 * far;
      }
    }
    p.constraints.C = C;
    p.constraints.C_min = lower;
    p.constraints.C_max = upper;
    if (random.index(2) == 0) {
      p.constraints.u_max = VectorXd::Constant(s.n_u, far);
      p.constraints.u_min = VectorXd::Constant(s.n_u, -far);
    }
    const Answer ours = solve(*make_interior_point_qp(s), p);
    const Answer osqp = solve(*make_osqp_qp(s, kOsqp), p);
    CAPTURE(seed, far, static_cast<int>(ours.report.status), static_cast<int>(osqp.report.status),
            ours.report.iterations, osqp.report.iterations, ours.report.primal_residual,
            ours.report.dual_residual, osqp.report.primal_residual, osqp.report.dual_residual);
    if (ours.report.status == QpStatus::kNotConverged) {
      // rows that all but contradict each other: met, if at all, by inputs that are out of all
      // measure
      CHECK(ours.z.bottomRows(s.n_lambda + s.n_u).cwiseAbs().maxCoeff() > 1e4 * far);
      ++failed;
      continue;
    }
    if (ours.report.status == QpStatus::kSolved) check_solved(p, ours, 1e-6);
    if (osqp.report.status == QpStatus::kNotConverged) {
      ++failed;
      continue;
    }
    CHECK(osqp.report.status == ours.report.status);
    if (osqp.report.status != QpStatus::kSolved) continue;
    ++solved;
    CHECK(error(p, osqp, ours) < 1e-4);
  }
  CAPTURE(solved, failed);
  CHECK(failed < test::property_instances() / 20);
  CHECK(solved > test::property_instances() / 2);
}
