#include "controller/scene/mechanism.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "tests/support/random.hpp"

using namespace c3rt::scene;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

TEST_CASE("mechanism: a rotation vector turns by its length about itself, and comes back") {
  CHECK((rotation(Vector3d(0.0, 0.0, 0.5 * M_PI)) * Vector3d::UnitX() - Vector3d::UnitY()).norm() <
        1e-15);
  c3rt::support::Random random(1);
  for (int i = 0; i < 200; ++i) {
    const double size = i < 20 ? std::pow(10.0, -i) : random.uniform(0.0, 3.14);
    const Vector3d turn = size * Vector3d(random.vector(3)).normalized();
    CHECK((rotation_vector(rotation(turn)) - turn).norm() < 1e-14 * (1.0 + 10.0 * size));
  }
  CHECK(rotation_vector(Matrix3d::Identity()).isZero(0.0));
}

TEST_CASE("mechanism: the left Jacobian is that of finite differences of the rotation") {
  c3rt::support::Random random(2);
  for (const double size : {0.0, 1e-8, 1e-4, 9e-4, 1.1e-3, 0.1, 1.0, 3.0}) {
    const Vector3d turn = size * Vector3d(random.vector(3)).normalized();
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kStep = 1e-6;
      const Vector3d by = kStep * Vector3d::Unit(axis);
      const Vector3d omega =
          rotation_vector(rotation(turn + by) * rotation(turn - by).transpose()) / (2.0 * kStep);
      CHECK((left_jacobian(turn).col(axis) - omega).norm() < 1e-9);
    }
  }
}

TEST_CASE("mechanism: coordinates move with v, rotations on their own group") {
  using Kind = Coordinate::Kind;
  const std::vector<Coordinate> coordinates{{Kind::kSlide, "s", "s_rate"},
                                            {Kind::kRotation, "x", "x_rate"},
                                            {Kind::kRotation, "y", "y_rate"},
                                            {Kind::kRotation, "z", "z_rate"},
                                            {Kind::kHinge, "h", "h_rate"}};
  VectorXd q(5), v(5);
  q << 1.0, 0.0, 0.0, 0.5 * M_PI, 2.0;
  v << 3.0, 0.5 * M_PI, 0.0, 0.0, -4.0;
  move(coordinates, v, 1.0, q);
  CHECK(q[0] == Approx(4.0));
  CHECK(q[4] == Approx(-2.0));
  // first x goes to y, then y to z
  CHECK((rotation(q.segment<3>(1)) * Vector3d::UnitX() - Vector3d::UnitZ()).norm() < 1e-14);
}
