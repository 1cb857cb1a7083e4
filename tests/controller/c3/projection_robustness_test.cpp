// Every projection on systems that no contact model would make: degenerate, without any
// complementary point, with units 16 orders apart.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "controller/c3/projection.hpp"
#include "controller/c3/solver.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::c3;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int kMaxNodes = 300;
// Of a row's terms and, for the MIQP, of the distance to the farthest of the half-spaces' borders.
constexpr double kInSet = 1e-9;

const std::vector<ProjectionKind> kKinds = [] {
  std::vector<ProjectionKind> kinds;
  for (const auto type : kProjectionTypes) kinds.push_back(type().kind);
  return kinds;
}();

std::unique_ptr<Projection> make(ProjectionKind kind, const Sizes& sizes) {
  Settings settings{};
  settings.projection = kind;
  settings.max_nodes = kMaxNodes;
  return make_projection(sizes, settings);
}

struct Problem {
  Sizes sizes;
  lcs::Lcs lcs;
  Costs costs;
  std::vector<VectorXd> v;  // each with the gaps that C3+ appends
};

MatrixXd definite_matrix(support::Random& random, int n) {
  const MatrixXd half = random.matrix(n, n);
  return half * half.transpose() + 0.05 * MatrixXd::Identity(n, n);
}

double power_of_ten(support::Random& random) { return std::pow(10.0, random.uniform(-8.0, 8.0)); }

MatrixXd complementarity_matrix(support::Random& random, int n, int kind) {
  const MatrixXd half = random.matrix(n, 1 + n / 2);
  switch (kind) {
    case 0:
      return MatrixXd::Zero(n, n);
    case 1:
      return random.matrix(n, n);
    case 2:
      return half * half.transpose();  // singular
    case 3:
      return -definite_matrix(random, n);
    default:
      return definite_matrix(random, n);
  }
}

Problem random_problem(support::Random& random, int trial, bool scaled) {
  const Sizes s{1 + random.index(5), 1 + random.index(7), 1 + random.index(3), 1};
  Problem p{s, {}, {}, {}};
  p.lcs.E = random.matrix(s.n_lambda, s.n_x);
  p.lcs.F = complementarity_matrix(random, s.n_lambda, trial % 6);
  p.lcs.H = random.matrix(s.n_lambda, s.n_u);
  p.lcs.c = random.vector(s.n_lambda);
  const auto each_block = [&](const auto& change) {
    change(p.lcs.E);
    change(p.lcs.F);
    change(p.lcs.H);
  };
  if (trial % 4 == 1 && s.n_lambda > 1) {  // the same row twice, once with its sign turned
    const double sign = trial % 8 == 1 ? 1.0 : -1.0;
    each_block([&](MatrixXd& block) { block.row(1) = sign * block.row(0); });
    p.lcs.c[1] = sign * p.lcs.c[0];
  }
  if (trial % 5 == 2) {  // a gap that nothing moves: open, closed, or negative: no point then
    each_block([](MatrixXd& block) { block.row(0).setZero(); });
    p.lcs.c[0] = static_cast<double>(random.index(3) - 1);
  }
  if (trial % 7 == 3) p.lcs.E.setZero();
  if (trial % 7 == 4) p.lcs.H.setZero();
  if (trial % 9 == 5) p.lcs.c.setZero();
  for (int i = 0; i < 4; ++i) p.v.push_back(2.0 * random.vector(s.n_z() + s.n_lambda));
  p.v[1].setZero();
  p.v[2] *= 1e6;
  p.costs.U = trial % 3 == 0 ? definite_matrix(random, s.n_z())
                             : MatrixXd(random.vector(s.n_z()).array().exp().matrix().asDiagonal());
  if (trial % 3 == 2) p.costs.U.diagonal().head(s.n_x).setZero();
  p.costs.convex = {definite_matrix(random, s.n_x), definite_matrix(random, s.n_u),
                    0.5 * (random.uniform() + 1.0), trial % 2 == 0 ? 0.0 : 1e-6};
  const VectorXd ones = VectorXd::Ones(s.n_lambda);
  p.costs.plus = {ones, ones, random.vector(s.n_lambda).array().exp(),
                  random.vector(s.n_lambda).array().exp()};
  if (!scaled) return p;
  for (int i = 0; i < s.n_lambda; ++i) {
    const double row = power_of_ten(random), column = power_of_ten(random);
    each_block([&](MatrixXd& block) { block.row(i) *= row; });
    p.lcs.c[i] *= row;
    p.lcs.F.col(i) *= column;
    for (VectorXd& v : p.v) v[s.n_x + i] /= column;
  }
  for (int i = 0; i < s.n_x; ++i) {
    const double column = power_of_ten(random);
    p.lcs.E.col(i) *= column;
    for (VectorXd& v : p.v) v[i] /= column;
  }
  return p;
}

/// How far the worst pair of `delta` is from complementary, beside what its row is made of.
double violation(const Problem& p, const VectorXd& v, const VectorXd& delta, bool weighted) {
  const Sizes& s = p.sizes;
  const int n = s.n_lambda, n_z = s.n_z();
  MatrixXd J = MatrixXd::Zero(2 * n, n_z);
  J.block(0, s.n_x, n, n).setIdentity();
  J.bottomRows(n) << p.lcs.E, p.lcs.F, p.lcs.H;
  VectorXd constant = VectorXd::Zero(2 * n);
  constant.tail(n) = p.lcs.c;
  VectorXd size = J.cwiseAbs() * (delta.cwiseAbs() + v.cwiseAbs()) + constant.cwiseAbs();
  if (weighted) {
    MatrixXd U = p.costs.U;
    const double largest = U.diagonal().maxCoeff();
    for (int i = 0; i < n_z; ++i) U(i, i) = std::max(U(i, i), 1e-8 * largest);
    const MatrixXd rows = J * support::inverse_root(U).transpose();
    const VectorXd length = rows.rowwise().norm();
    const VectorXd distance =
        (J * v + constant).cwiseAbs().cwiseQuotient(length.cwiseMax(1e-300)).cwiseMin(1e300);
    double farthest = 0.0;
    for (int i = 0; i < 2 * n; ++i) {
      if (length[i] > 0.0) farthest = std::max(farthest, distance[i]);
    }
    size += farthest * length;
  }
  if (!weighted) {  // the largest force leaves 1e-12 of itself in any other one
    size.tail(n) += 1e-3 * s.lambda(delta).maxCoeff() * p.lcs.F.cwiseAbs().rowwise().sum();
  }
  const VectorXd sides = J * delta + constant;
  double worst = 0.0;
  for (int i = 0; i < n; ++i) {
    const auto relative = [&](int row) {
      return size[row] > 0.0 ? sides[row] / size[row] : sides[row];
    };
    worst = std::max(worst, std::abs(std::min(relative(i), relative(n + i))));
  }
  return worst;
}

bool same_bits(const VectorXd& a, const VectorXd& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

int rows_of(const Problem& p, ProjectionKind kind) {
  return projection_type(kind).make_consensus(p.sizes)->n_copy();
}

void check_all(const Problem& p, int trial, std::vector<int>& solved) {
  for (const ProjectionKind kind : kKinds) {
    const auto projection = make(kind, p.sizes);
    projection->set_weights(p.costs);
    projection->start(p.lcs);
    for (std::size_t i = 0; i < p.v.size(); ++i) {
      const VectorXd v = p.v[i].head(rows_of(p, kind));
      VectorXd delta = VectorXd::Constant(v.size(), std::numeric_limits<double>::quiet_NaN());
      const ProjectionReport report = projection->project(v, delta, {});
      CAPTURE(trial, static_cast<int>(kind), i, static_cast<int>(report.status), report.nodes);
      CHECK(delta.allFinite());
      CHECK(std::isfinite(report.objective));
      CHECK(report.status != ProjectionStatus::kNotFinite);
      CHECK(report.status != ProjectionStatus::kDeadline);
      if (!has_point(report.status)) CHECK(delta == v);
      if (kind == ProjectionKind::kMiqp) CHECK(report.nodes <= kMaxNodes);
      if (kind == ProjectionKind::kAdmm) CHECK(report.nodes <= AdmmProjectionSettings{}.iterations);
      if (report.status != ProjectionStatus::kSolved) continue;
      ++solved[static_cast<std::size_t>(kind)];
      if (kind == ProjectionKind::kMiqp) CHECK(violation(p, v, delta, true) < kInSet);
      if (kind == ProjectionKind::kLcp) CHECK(violation(p, v, delta, false) < kInSet);
      if (kind != ProjectionKind::kAdmm) CHECK(p.sizes.lambda(delta).minCoeff() >= 0.0);
    }
  }
}

}  // namespace

TEST_CASE(
    "projections: random and degenerate systems end in a status, and what is solved is in the "
    "set") {
  support::Random random(61);
  std::vector<int> solved(kKinds.size(), 0);
  for (int trial = 0; trial < 400; ++trial)
    check_all(random_problem(random, trial, false), trial, solved);
  for (const int count : solved) CHECK(count > 300);
}

TEST_CASE("projections: the same with every row and column in units of its own, 1e-8 to 1e8") {
  support::Random random(62);
  std::vector<int> solved(kKinds.size(), 0);
  for (int trial = 0; trial < 400; ++trial)
    check_all(random_problem(random, trial, true), trial, solved);
  for (const int count : solved) CHECK(count > 100);
}

TEST_CASE("projections: the answer depends on v alone, to the bit, and on no call before") {
  support::Random random(63);
  for (int trial = 0; trial < 60; ++trial) {
    const Problem p = random_problem(random, trial, trial % 4 == 3);
    const Problem other = [&] {  // the same sizes, another system
      Problem changed = p;
      changed.lcs.F = definite_matrix(random, p.sizes.n_lambda);
      changed.lcs.c = random.vector(p.sizes.n_lambda);
      return changed;
    }();
    for (const ProjectionKind kind : kKinds) {
      const auto used = make(kind, p.sizes);
      used->set_weights(p.costs);
      used->start(other.lcs);
      VectorXd delta(rows_of(p, kind));
      for (const VectorXd& v : p.v) (void)used->project(v.head(delta.size()), delta, {});
      used->start(p.lcs);
      for (std::size_t i = p.v.size(); i-- > 0;) {
        const VectorXd v = p.v[i].head(delta.size());
        const ProjectionReport report = used->project(v, delta, {});
        const auto fresh = make(kind, p.sizes);
        fresh->set_weights(p.costs);
        fresh->start(p.lcs);
        VectorXd expected(delta.size());
        const ProjectionReport first = fresh->project(v, expected, {});
        CAPTURE(trial, static_cast<int>(kind), i);
        CHECK(report.status == first.status);
        CHECK(report.nodes == first.nodes);
        CHECK(same_bits(delta, expected));
      }
    }
  }
}

TEST_CASE("projections: start and project do not touch the heap") {
  support::Random random(64);
  for (int trial = 0; trial < 40; ++trial) {
    const Problem p = random_problem(random, trial, trial % 4 == 3);
    for (const ProjectionKind kind : kKinds) {
      const auto projection = make(kind, p.sizes);
      projection->set_weights(p.costs);
      VectorXd delta(rows_of(p, kind));
      std::vector<VectorXd> targets;
      for (const VectorXd& v : p.v) targets.push_back(v.head(delta.size()));
      std::int64_t heap_calls = -1;
      {
        const support::AllocationCounter heap;
        projection->start(p.lcs);
        for (const VectorXd& v : targets) (void)projection->project(v, delta, {});
        heap_calls = heap.count();
      }
      CAPTURE(trial, static_cast<int>(kind));
      CHECK(heap_calls == 0);
    }
  }
}

TEST_CASE("projections: a large one does not touch the heap either") {
  support::Random random(65);
  const Sizes s{19, 24, 3, 1};
  lcs::Lcs lcs;
  lcs.E = random.matrix(24, 19);
  lcs.F = definite_matrix(random, 24);
  lcs.H = random.matrix(24, 3);
  lcs.c = random.vector(24);
  Costs costs;
  costs.U = definite_matrix(random, s.n_z());
  costs.convex = {definite_matrix(random, 19), definite_matrix(random, 3), 0.5, 1e-6};
  const VectorXd v = random.vector(s.n_z());
  VectorXd delta(s.n_z());
  for (const ProjectionKind kind : {ProjectionKind::kMiqp, ProjectionKind::kLcp,
                                    ProjectionKind::kAdmm, ProjectionKind::kConvex}) {
    const auto projection = make(kind, s);
    projection->set_weights(costs);
    ProjectionReport report{};
    std::int64_t heap_calls = -1;
    {
      const support::AllocationCounter heap;
      projection->start(lcs);
      report = projection->project(v, delta, {});
      heap_calls = heap.count();
    }
    CAPTURE(static_cast<int>(kind));
    CHECK(has_point(report.status));
    CHECK(heap_calls == 0);
  }
}

TEST_CASE("projections: NaN and infinity are a status, and delta is v then") {
  support::Random random(66);
  const Problem p = random_problem(random, 4, false);
  for (const ProjectionKind kind : kKinds) {
    const auto projection = make(kind, p.sizes);
    projection->set_weights(p.costs);
    projection->start(p.lcs);
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      VectorXd v = p.v[0].head(rows_of(p, kind)), delta(v.size());
      for (Eigen::Index i = 0; i < v.size(); ++i) {
        VectorXd spoilt = v;
        spoilt[i] = bad;
        CHECK(projection->project(spoilt, delta, {}).status == ProjectionStatus::kNotFinite);
        CHECK(same_bits(delta, spoilt));
      }
      // and the next call knows nothing of it
      CHECK(projection->project(v, delta, {}).status != ProjectionStatus::kNotFinite);
    }
  }
}

TEST_CASE(
    "projections: the iterating ones stop when the deadline strikes, with a point or without") {
  struct Countdown {
    int left, asked;
    static bool reached(void* context) noexcept {
      auto& self = *static_cast<Countdown*>(context);
      ++self.asked;
      return --self.left < 0;
    }
  };
  support::Random random(67);
  int with_point = 0, without = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Problem p = random_problem(random, 5, false);  // F is positive definite
    for (const ProjectionKind kind : {ProjectionKind::kMiqp, ProjectionKind::kAdmm}) {
      const auto projection = make(kind, p.sizes);
      projection->set_weights(p.costs);
      projection->start(p.lcs);
      const VectorXd v = p.v[0].head(p.sizes.n_z());
      VectorXd delta(v.size());
      const long all = projection->project(v, delta, {}).nodes;
      for (int questions = 0; questions < all; ++questions) {
        Countdown countdown{questions, 0};
        const ProjectionReport report =
            projection->project(v, delta, {&Countdown::reached, &countdown});
        CAPTURE(trial, static_cast<int>(kind), questions, all);
        CHECK(countdown.asked == questions + 1);
        CHECK(report.nodes == questions);
        if (!has_point(report.status)) {
          CHECK(report.status == ProjectionStatus::kNotFound);
          CHECK(delta == v);
          ++without;
        } else {
          CHECK(report.status == ProjectionStatus::kDeadline);
          ++with_point;
          if (kind == ProjectionKind::kMiqp) CHECK(violation(p, v, delta, true) < kInSet);
        }
      }
    }
  }
  REQUIRE(with_point > 50);
  REQUIRE(without > 50);
}
