#include "tests/support/linear_algebra.hpp"

#include <Eigen/Core>
#include <catch2/catch.hpp>

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

TEST_CASE("linear algebra: two by two by hand") {
  MatrixXd A(2, 2), B(2, 2), dependent(2, 2);
  A << 2.0, 1.0, 1.0, 2.0;
  B << 4.0, 0.0, 0.0, 1.0;
  dependent << 1.0, 2.0, 2.0, 4.0;
  const VectorXd b = Eigen::Vector2d(3.0, 0.0), x = Eigen::Vector2d(2.0, -1.0);
  CHECK((support::solve_definite(A, b) - x).norm() < 1e-14);
  CHECK((support::solve(A, b).value() - x).norm() < 1e-14);
  CHECK((support::inverse(A) * b - x).norm() < 1e-14);
  CHECK(!support::solve(dependent, b));
  // of all x with x_0 + 2 x_1 = 1 the one along (1, 2)
  CHECK((support::least_squares(dependent, Eigen::Vector2d(1.0, 2.0)) - Eigen::Vector2d(0.2, 0.4))
            .norm() < 1e-14);
  CHECK((support::inverse_root(B) * Eigen::Vector2d(2.0, 1.0) - Eigen::Vector2d(1.0, 1.0)).norm() <
        1e-14);
  CHECK(support::is_definite(A));
  CHECK(!support::is_definite(-A));
  CHECK((support::eigenvalues(A) - Eigen::Vector2d(1.0, 3.0)).norm() < 1e-14);
  // of diag(8, 3) v = λ B v
  const MatrixXd diagonal = Eigen::Vector2d(8.0, 3.0).asDiagonal();
  CHECK((support::eigenvalues(diagonal, B) - Eigen::Vector2d(2.0, 3.0)).norm() < 1e-14);
}

TEST_CASE("linear algebra: a turn brings one direction onto the other, the shortest way") {
  const Vector3d from = Vector3d(1.0, 2.0, -2.0) / 3.0, to = Vector3d(2.0, 1.0, 2.0) / 3.0;
  const Eigen::Quaterniond q = support::turn(from, to);
  CHECK((q * from - to).norm() < 1e-14);
  CHECK(q.vec().dot(from) == Approx(0.0).margin(1e-14));  // no turn about itself
}
