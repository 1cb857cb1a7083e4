#include "controller/qp/riccati.hpp"

#include <cmath>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "tests/controller/qp/qp_problem.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::qp;
using namespace qp_problem;

namespace {

/// Everything as a function of all ν, dense: z and x_N are Φ ν + what ν = 0 gives.
struct Dense {
  MatrixXd Phi, H;  // H of all z and x_N

  explicit Dense(const Problem& p) {
    const Sizes& s = p.sizes;
    const int n_x = s.n_x, n_z = s.n_z(), n_nu = s.n_lambda + s.n_u, n = s.N * n_z + n_x;
    Phi = MatrixXd::Zero(n, s.N * n_nu);
    H = MatrixXd::Zero(n, n);
    for (int k = 0; k < s.N; ++k) {
      Phi.block(k * n_z + n_x, k * n_nu, n_nu, n_nu).setIdentity();
      MatrixXd step(n_x, n_z);
      step << p.lcs[k].A, p.lcs[k].D, p.lcs[k].B;
      Phi.middleRows((k + 1) * n_z, n_x) = step * Phi.middleRows(k * n_z, n_z);
      H.block(k * n_z, k * n_z, n_z, n_z) = p.W[k];
      H.block(k * n_z, k * n_z, n_x, n_x) += p.costs.Q[k];
    }
    H.bottomRightCorner(n_x, n_x) = p.costs.Q_N;
    if (p.fixes_lambda_0) Phi.leftCols(s.n_lambda).setZero();
  }
  /// (Φᵀ H Φ)⁻¹ over the inputs that move anything.
  MatrixXd inverse(const Problem& p) const {
    const int fixed = p.fixes_lambda_0 ? p.sizes.n_lambda : 0;
    const Eigen::Index free = Phi.cols() - fixed;
    const MatrixXd reduced = Phi.rightCols(free).transpose() * H * Phi.rightCols(free);
    return Phi.rightCols(free) * reduced.inverse() * Phi.rightCols(free).transpose();
  }
};

std::vector<MatrixXd> hessians(const Problem& p) {
  std::vector<MatrixXd> H = p.W;
  for (int k = 0; k < p.sizes.N; ++k) {
    H[k].topLeftCorner(p.sizes.n_x, p.sizes.n_x) += p.costs.Q[k];
  }
  return H;
}

Problem problem(unsigned seed) {
  Problem p = random_problem(seed);
  p.fixes_lambda_0 = seed % 2 == 1;
  // zeros, which it looks for
  support::Random random(seed);
  for (lcs::Lcs& lcs : p.lcs) {
    for (MatrixXd* m : {&lcs.A, &lcs.B, &lcs.D}) {
      for (Eigen::Index i = 0; i < m->size(); ++i) {
        if (random.index(3) == 0) m->data()[i] = 0.0;
      }
    }
  }
  return p;
}

}  // namespace

TEST_CASE(
    "Riccati: a step is the minimiser of the dense model at the states that the dynamics lead to") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Problem p = problem(seed);
    const Sizes& s = p.sizes;
    const Dense dense(p);
    const std::vector<MatrixXd> H = hessians(p);
    Riccati riccati(s);
    riccati.start({p.lcs.data(), 1}, p.fixes_lambda_0);
    REQUIRE(riccati.factor({H.data(), 1}, p.costs.Q_N));
    support::Random random(seed + 100);
    const MatrixXd gradient = random.matrix(s.n_z(), s.N);
    const VectorXd gradient_N = random.vector(s.n_x);
    // a point that misses the dynamics, and the step along them that takes the defects out alone
    const MatrixXd z = random.matrix(s.n_z(), s.N);
    const VectorXd x_N = random.vector(s.n_x);
    MatrixXd defect(s.n_x, s.N), along = MatrixXd::Zero(s.n_z(), s.N);
    riccati.defects(z, x_N, defect);
    CHECK(riccati.relative_defect(z, x_N, defect) > 0.1);
    VectorXd x = VectorXd::Zero(s.n_x);
    for (int k = 0; k < s.N; ++k) {
      s.x(along.col(k)) = x;
      const VectorXd next = k + 1 < s.N ? VectorXd(s.x(z.col(k + 1))) : x_N;
      const VectorXd expected = next - p.lcs[k].A * s.x(z.col(k)) - p.lcs[k].B * s.u(z.col(k)) -
                                p.lcs[k].D * s.lambda(z.col(k)) - p.lcs[k].d;
      CHECK((defect.col(k) - expected).cwiseAbs().maxCoeff() < 1e-13);
      x = p.lcs[k].A * x - expected;
    }
    MatrixXd step = MatrixXd::Constant(s.n_z(), s.N, NAN);
    VectorXd step_N = VectorXd::Constant(s.n_x, NAN);
    riccati.step(gradient, gradient_N, defect, step, step_N);
    VectorXd all(s.N * s.n_z() + s.n_x), shift(all.size());
    all << gradient.reshaped(), gradient_N;
    shift << along.reshaped(), x;
    const VectorXd expected = shift - dense.inverse(p) * (all + dense.H * shift);
    VectorXd got(all.size());
    got << step.reshaped(), step_N;
    CAPTURE(seed);
    CHECK((got - expected).cwiseAbs().maxCoeff() < 1e-10 * expected.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("Riccati: stationarity is what the multipliers of the dynamics leave of a gradient") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Problem p = problem(seed);
    const Sizes& s = p.sizes;
    const std::vector<MatrixXd> H = hessians(p);
    Riccati riccati(s);
    riccati.start({p.lcs.data(), 1}, p.fixes_lambda_0);
    REQUIRE(riccati.factor({H.data(), 1}, p.costs.Q_N));
    support::Random random(seed + 100);
    const MatrixXd gradient = random.matrix(s.n_z(), s.N), z = random.matrix(s.n_z(), s.N);
    const VectorXd gradient_N = random.vector(s.n_x), x_N = random.vector(s.n_x);
    MatrixXd defect(s.n_x, s.N);
    riccati.defects(z, x_N, defect);
    const Riccati::Stationarity found =
        riccati.stationarity_of_multipliers(gradient, gradient_N, defect);
    // along any way e that the dynamics allow from here, gᵀe is at most what is left times e, and
    // what the multipliers make of the defects
    for (int trial = 0; trial < 20; ++trial) {
      VectorXd x = VectorXd::Zero(s.n_x);
      double along = 0.0, size_x = 0.0;
      for (int k = 0; k < s.N; ++k) {
        VectorXd nu = random.vector(s.n_lambda + s.n_u);
        if (k == 0 && p.fixes_lambda_0) nu.head(s.n_lambda).setZero();
        along += s.x(gradient.col(k)).dot(x) + gradient.col(k).tail(nu.size()).dot(nu);
        if (k > 0) size_x = std::max(size_x, x.cwiseAbs().maxCoeff());
        x = p.lcs[k].A * x + p.lcs[k].D * nu.head(s.n_lambda) + p.lcs[k].B * nu.tail(s.n_u) -
            defect.col(k);
      }
      along += gradient_N.dot(x);
      CAPTURE(seed, trial);
      CHECK(std::abs(along + found.defect) <=
            found.input_sum + found.state_sum * size_x + 1e-9 * std::abs(along));
    }
    // and at the model's minimiser nothing is left
    MatrixXd at = MatrixXd::Zero(s.n_z(), s.N), left = gradient;
    VectorXd at_N(s.n_x), left_N = gradient_N;
    riccati.step(gradient, gradient_N, MatrixXd::Zero(s.n_x, s.N), at, at_N);
    for (int k = 0; k < s.N; ++k) left.col(k) += H[k] * at.col(k);
    left_N += p.costs.Q_N * at_N;
    const Riccati::Stationarity none = riccati.stationarity(left, left_N, at);
    CHECK(none.input <= 1e-12 * none.input_scale);
    CHECK(none.state <= 1e-12 * none.state_scale);
    CHECK(none.is_known);
    CHECK(found.input > 1e-3 * found.input_scale);
  }
}

TEST_CASE("Riccati: factoring anew up to the last change gives the bits of factoring all") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Problem p = problem(seed);
    const Sizes& s = p.sizes;
    support::Random random(seed + 100);
    const MatrixXd gradient = random.matrix(s.n_z(), s.N);
    const VectorXd gradient_N = random.vector(s.n_x);
    for (int last = 0; last < s.N; ++last) {
      std::vector<MatrixXd> H = hessians(p);
      Riccati part(s), all(s);
      part.start({p.lcs.data(), 1}, p.fixes_lambda_0);
      all.start({p.lcs.data(), 1}, p.fixes_lambda_0);
      REQUIRE(part.factor({H.data(), 1}, p.costs.Q_N));
      for (int k = 0; k <= last; ++k) H[k].diagonal().array() += 1.0;
      REQUIRE(part.factor({H.data(), 1}, p.costs.Q_N, last));
      REQUIRE(all.factor({H.data(), 1}, p.costs.Q_N));
      MatrixXd step(s.n_z(), s.N), expected(s.n_z(), s.N);
      VectorXd step_N(s.n_x), expected_N(s.n_x);
      const MatrixXd defect = MatrixXd::Constant(s.n_x, s.N, 0.1);
      part.step(gradient, gradient_N, defect, step, step_N);
      all.step(gradient, gradient_N, defect, expected, expected_N);
      CAPTURE(seed, last);
      CHECK(step == expected);
      CHECK(step_N == expected_N);
    }
  }
}

TEST_CASE("Riccati: rank_one_terms kept beside the Hessians count as if they were part of them") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Problem p = problem(seed);
    const Sizes& s = p.sizes;
    support::Random random(seed + 300);
    std::vector<MatrixXd> H = hessians(p);
    MatrixXd H_N = p.costs.Q_N;
    const std::vector<MatrixXd> H_bare = H;
    const MatrixXd normals = random.matrix(s.n_z(), s.N);
    RankOneTerms rank_one_terms;
    rank_one_terms.prepare(s.N, 3 * s.N + 1);
    for (int k = 0; k < s.N; ++k) {
      const VectorXd a = normals.col(k);
      rank_one_terms.add(k, -1, normals.col(k).data(), 0.7);
      H[k] += 0.7 * a * a.transpose();
      for (int entry : {random.index(s.n_x), s.n_x + random.index(s.n_z() - s.n_x)}) {
        rank_one_terms.add(k, entry, nullptr, 3.0);
        H[k](entry, entry) += 3.0;
      }
    }
    rank_one_terms.add(s.N, 0, nullptr, 5.0);
    H_N(0, 0) += 5.0;
    const MatrixXd gradient = random.matrix(s.n_z(), s.N);
    const VectorXd gradient_N = random.vector(s.n_x);
    const auto step = [&](const std::vector<MatrixXd>& hessians, const MatrixXd& last,
                          const RankOneTerms* beside) {
      Riccati riccati(s);
      riccati.start({p.lcs.data(), 1}, p.fixes_lambda_0);
      REQUIRE(riccati.factor({hessians.data(), 1}, last, s.N, beside));
      MatrixXd z(s.n_z(), s.N);
      VectorXd x_N(s.n_x), all(z.size() + s.n_x);
      riccati.step(gradient, gradient_N, MatrixXd::Zero(s.n_x, s.N), z, x_N);
      all << z.reshaped(), x_N;
      return all;
    };
    const VectorXd expected = step(H, H_N, nullptr);
    CAPTURE(seed);
    CHECK((step(H_bare, p.costs.Q_N, &rank_one_terms) - expected).cwiseAbs().maxCoeff() <
          1e-12 * expected.cwiseAbs().maxCoeff());
    rank_one_terms.clear();
    CHECK(step(H, H_N, &rank_one_terms) == expected);
  }
}

TEST_CASE(
    "Riccati: the inverse_hessian is at most the dense one, near it, and exact at the first "
    "stages") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Problem p = problem(seed);
    const Sizes& s = p.sizes;
    const MatrixXd inverse = Dense(p).inverse(p);
    const std::vector<MatrixXd> H = hessians(p);
    Riccati riccati(s);
    riccati.start({p.lcs.data(), 1}, p.fixes_lambda_0);
    REQUIRE(riccati.factor({H.data(), 1}, p.costs.Q_N));
    support::Random random(seed + 100);
    for (int k = 0; k <= s.N; ++k) {
      const VectorXd a = random.vector(k < s.N ? s.n_z() : s.n_x);
      const double exact = a.dot(inverse.block(k * s.n_z(), k * s.n_z(), a.size(), a.size()) * a);
      const double got = riccati.inverse_hessian_along(k, a);
      CAPTURE(seed, k, s.N);
      CHECK(got <= exact * (1.0 + 1e-9));
      CHECK(got >= 0.01 * exact);
      if (k <= 1) CHECK(got == Approx(exact).epsilon(1e-9));
    }
  }
}

TEST_CASE("Riccati: a problem that is not convex is refused, not solved") {
  const Problem p = problem(4);
  std::vector<MatrixXd> H = hessians(p);
  H[0].diagonal().tail(p.sizes.n_u).setConstant(-1e6);
  Riccati riccati(p.sizes);
  riccati.start({p.lcs.data(), 1}, false);
  REQUIRE_FALSE(riccati.factor({H.data(), 1}, p.costs.Q_N));
  H[0].setConstant(NAN);
  REQUIRE_FALSE(riccati.factor({H.data(), 1}, p.costs.Q_N));
}

TEST_CASE(
    "kernels: every sum has the bits of the plain loop, so the vectors' width cannot matter") {
  support::Random random(11);
  for (int rows = 1; rows <= 30; ++rows) {
    const int n = 1 + random.index(17), ld = kernels::padded(rows), ld_L = kernels::padded(n);
    MatrixXd X = random.matrix(ld, n), L = random.matrix(ld_L, n);
    X.bottomRows(ld - rows).setZero();
    const VectorXd c = random.vector(n), y = random.vector(ld), inverse = random.vector(n);

    VectorXd plain = y, got = y;
    for (int j = 0; j < n; ++j) plain.head(rows) -= c[j] * X.col(j).head(rows);
    kernels::subtract_columns(rows, n, X.data(), c.data(), got.data());
    CHECK(got.head(rows) == plain.head(rows));
    CHECK(kernels::largest(rows, y.data()) == y.head(rows).cwiseAbs().maxCoeff());
    VectorXd broken = y;
    for (const double bad : {std::nan(""), HUGE_VAL}) {
      broken[random.index(rows)] = bad;
      CHECK(std::isnan(kernels::largest(rows, broken.data())));
    }
    CHECK(kernels::largest(rows, n, X.data(), ld) == X.topRows(rows).cwiseAbs().maxCoeff());
    MatrixXd turned = MatrixXd::Constant(ld_L, rows, 7.0);
    kernels::transpose(rows, n, X.data(), turned.data());
    CHECK(turned.topRows(n) == X.topRows(rows).transpose());
    CHECK((turned.bottomRows(ld_L - n).array() == 0.0).all());

    plain = got = y;
    for (int j = 0; j < n; ++j) plain.head(rows) += c[j] * X.col(j).head(rows);
    kernels::add_columns(rows, n, X.data(), ld, c.data(), got.data());
    CHECK(got == plain);

    const VectorXd a = random.vector(rows), b = random.vector(rows);
    VectorXd sum = VectorXd::Zero(rows), remainder = a, result(rows);
    for (int j = 0; j < n; ++j) {
      sum += c[j] * X.col(j).head(rows);
      remainder += c[j] * X.col(j).head(rows);
    }
    kernels::product_minus(rows, n, X.data(), ld, c.data(), b.data(), result.data());
    CHECK(result == sum - b);
    kernels::minus_product(rows, n, X.data(), ld, c.data(), a.data(), b.data(), result.data());
    CHECK(result == b - remainder);
    kernels::largest_of_rows(rows, n, X.data(), ld, result.data());
    CHECK(result == X.topRows(rows).cwiseAbs().rowwise().maxCoeff());
    VectorXd of_columns(n);
    kernels::largest_of_columns(rows, n, X.data(), ld, of_columns.data());
    CHECK(of_columns == X.cwiseAbs().colwise().maxCoeff().transpose());

    VectorXd plain_terms = plain = VectorXd::Zero(ld), got_terms(ld);
    for (int j = 0; j < n; ++j) {
      plain += c[j] * X.col(j);
      plain_terms += (c[j] * X.col(j)).cwiseAbs();
    }
    kernels::product_and_terms(rows, n, X.data(), c.data(), got.data(), got_terms.data());
    CHECK(got == plain);
    CHECK(got_terms == plain_terms);

    MatrixXd plain_Y = X, got_Y = X;
    for (int j = 0; j < n; ++j) {
      for (int m = 0; m < j; ++m) plain_Y.col(j) -= L(j, m) * plain_Y.col(m);
      plain_Y.col(j) *= inverse[j];
    }
    kernels::solve_right(rows, n, L.data(), inverse.data(), got_Y.data());
    CHECK(got_Y == plain_Y);

    MatrixXd square = random.matrix(ld, rows), plain_square = square;
    for (int j = 0; j < rows; ++j) {
      for (int m = 0; m < n; ++m) plain_square.col(j) -= X(j, m) * X.col(m);
    }
    kernels::subtract_gram(rows, n, X.data(), square.data());
    for (int j = 0; j < rows; ++j) {
      CHECK(square.col(j).segment(j, rows - j) == plain_square.col(j).segment(j, rows - j));
    }
  }
}

TEST_CASE("kernels: the Cholesky factor gives the matrix back, a matrix without one gives false") {
  support::Random random(12);
  for (int n = 1; n <= 20; ++n) {
    const int ld = kernels::padded(n);
    MatrixXd X = MatrixXd::Zero(ld, n), L = X;
    X.topRows(n) = definite(random, n);
    VectorXd inverse(n);
    REQUIRE(kernels::cholesky(n, X.data(), L.data(), inverse.data()));
    const MatrixXd lower = L.topRows(n).triangularView<Eigen::Lower>();
    CHECK((lower * lower.transpose() - X.topRows(n)).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((inverse.cwiseProduct(lower.diagonal()) - VectorXd::Ones(n)).cwiseAbs().maxCoeff() <
          1e-14);
    X(n - 1, n - 1) -= 1e3;
    CHECK_FALSE(kernels::cholesky(n, X.data(), L.data(), inverse.data()));
  }
}

TEST_CASE("Riccati: start, factor and step do not allocate") {
  if (!support::AllocationCounter::counts()) return;  // a sanitizer owns malloc
  const Problem p = problem(5);
  const std::vector<MatrixXd> H = hessians(p);
  Riccati riccati(p.sizes);
  const MatrixXd gradient = MatrixXd::Ones(p.sizes.n_z(), p.sizes.N);
  const VectorXd gradient_N = VectorXd::Ones(p.sizes.n_x);
  MatrixXd step(p.sizes.n_z(), p.sizes.N);
  MatrixXd defect(p.sizes.n_x, p.sizes.N);
  VectorXd step_N(p.sizes.n_x);
  const support::AllocationCounter counter;
  riccati.start({p.lcs.data(), 1}, true);
  const bool factored = riccati.factor({H.data(), 1}, p.costs.Q_N);
  riccati.defects(gradient, gradient_N, defect);
  const double inconsistency = riccati.relative_defect(gradient, gradient_N, defect);
  riccati.step(gradient, gradient_N, defect, step, step_N);
  const double inverse_hessian = riccati.inverse_hessian_along(p.sizes.N, gradient_N);
  const double left = riccati.stationarity(gradient, gradient_N, gradient).input;
  const auto calls = counter.count();
  REQUIRE(factored);
  REQUIRE(inverse_hessian > 0.0);
  REQUIRE(left > 0.0);
  REQUIRE(inconsistency > 0.0);
  REQUIRE(calls == 0);
}
