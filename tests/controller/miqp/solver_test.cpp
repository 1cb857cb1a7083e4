#include "controller/miqp/solver.hpp"

#include <limits>

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <unistd.h>

#include "tests/support/random.hpp"

using namespace c3rt;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// n continuous variables, each of which may leave zero only where its binary is one, and a limit
/// on how many may: the best subset of a least-squares problem.
miqp::Problem best_subset(const Eigen::MatrixXd& H, const Eigen::VectorXd& q, int allowed) {
  const auto n = q.size();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  P.topLeftCorner(n, n) = H;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n + 1, 2 * n);
  A.block(0, 0, n, n).setIdentity();  // x ≤ 10 b, −x ≤ 10 b, Σ b ≤ allowed
  A.block(n, 0, n, n).diagonal().setConstant(-1.0);
  A.block(0, n, n, n).diagonal().setConstant(-10.0);
  A.block(n, n, n, n).diagonal().setConstant(-10.0);
  A.row(2 * n).tail(n).setOnes();
  miqp::Problem problem;
  problem.P = P.sparseView();
  problem.q = Eigen::VectorXd::Zero(2 * n);
  problem.q.head(n) = q;
  problem.A = A.sparseView();
  problem.l = Eigen::VectorXd::Constant(2 * n + 1, -kInfinity);
  problem.u = Eigen::VectorXd::Zero(2 * n + 1);
  problem.u[2 * n] = allowed;
  problem.x_min = Eigen::VectorXd::Constant(2 * n, -kInfinity);
  problem.x_max = Eigen::VectorXd::Constant(2 * n, kInfinity);
  for (int i = 0; i < n; ++i) problem.binaries.push_back(static_cast<int>(n) + i);
  return problem;
}

}  // namespace

TEST_CASE("the optimum is that of enumerating all subsets") {
  support::Random random(1);
  for (int i = 0; i < 3; ++i) {
    constexpr int n = 5, kAllowed = 2;
    const Eigen::MatrixXd root = random.matrix(n, n);
    const Eigen::MatrixXd H = root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd q = random.vector(n);
    double best = 0.0;
    for (int first = 0; first < n; ++first) {
      for (int second = first + 1; second < n; ++second) {
        Eigen::Matrix2d part;
        part << H(first, first), H(first, second), H(second, first), H(second, second);
        const Eigen::Vector2d slope(q[first], q[second]);
        const Eigen::Vector2d x = -part.ldlt().solve(slope);
        REQUIRE(x.cwiseAbs().maxCoeff() < 10.0);
        best = std::min(best, slope.dot(x));
      }
    }
    const miqp::Result result = miqp::solve(best_subset(H, q, kAllowed), {});
    REQUIRE(result.status == miqp::Status::kOptimal);
    CHECK(result.objective == Approx(best).epsilon(2e-4));
    CHECK(result.gap <= 1e-4 + 1e-6);
    CHECK(result.x.tail(n).sum() <= kAllowed + 1e-5);
  }
}

TEST_CASE("a problem without a point is infeasible or failed, never optimal") {
  miqp::Problem problem = best_subset(Eigen::Matrix2d::Identity(), Eigen::Vector2d(1, 1), 1);
  problem.l[4] = 1.5;  // 1.5 ≤ b_0 + b_1 ≤ 1.6: the relaxation has points
  problem.u[4] = 1.6;
  const miqp::Result result = miqp::solve(problem, {});
  CHECK((result.status == miqp::Status::kInfeasible || result.status == miqp::Status::kFailed));
  CHECK(result.x.size() == 0);
}

TEST_CASE("wrong sizes and numbers are refused by name") {
  const miqp::Problem good = best_subset(Eigen::Matrix2d::Identity(), Eigen::Vector2d(1, 1), 1);
  const auto refused = [](const miqp::Problem& problem, const char* text) {
    CHECK_THROWS_WITH(miqp::solve(problem, {}), Catch::Contains(text));
  };
  miqp::Problem bad = good;
  bad.l.resize(2);
  refused(bad, "Problem.l: expected size 5, got 2");
  bad = good;
  bad.q[1] = std::numeric_limits<double>::quiet_NaN();
  refused(bad, "Problem.q");
  bad = good;
  bad.binaries.push_back(9);
  refused(bad, "Problem.binaries");
}

TEST_CASE("a solve writes nothing to the standard streams") {
  std::FILE* file = std::tmpfile();
  REQUIRE(file != nullptr);
  const int saved_out = dup(1), saved_err = dup(2);
  std::fflush(stdout);
  dup2(fileno(file), 1);
  dup2(fileno(file), 2);
  const miqp::Result result =
      miqp::solve(best_subset(Eigen::Matrix3d::Identity(), Eigen::Vector3d(1, 2, 3), 1), {});
  std::fflush(stdout);
  std::fflush(stderr);
  dup2(saved_out, 1);
  dup2(saved_err, 2);
  close(saved_out);
  close(saved_err);
  std::fseek(file, 0, SEEK_END);
  CHECK(std::ftell(file) == 0);
  std::fclose(file);
  CHECK(result.status == miqp::Status::kOptimal);
}
