#pragma once
// Boxes and plates on a table, with many redundant contacts: the complementarity problems of
// Stewart and Trinkle that are hardest for a pivoting method, because nearly all of their ratios
// tie.
#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/model/contact_system.hpp"
#include "tests/support/random.hpp"

namespace c3rt::support {

/// LCP(q, F) of one step and what its q was added up from: |c| + |E x| + |H u|, row by row.
struct ContactLcp {
  Eigen::MatrixXd F;
  Eigen::VectorXd q, terms;
  lcs::Lcs lcs;
  Eigen::VectorXd x, u;
};

/// A rigid body (x = position, small rotation, velocity, angular velocity; u = force at its centre)
/// on 4 to 10 corners, at most 64 rows: flat, tilted or sunk, by rounding or more; at rest,
/// sliding, spinning or falling; 4 or more edges of the friction cone, μ from 0 to 1.5. In the
/// round numbers in which ties are exact, or turned about the vertical, which leaves rounding in
/// them.
inline ContactLcp resting_box(Random& random) {
  using Eigen::Vector3d;
  using Eigen::VectorXd;
  const int n_c = 4 + random.index(7);
  int n_e = 4 + 2 * random.index(3);
  while (n_c * (2 + n_e) > 64) n_e = 4 + 2 * random.index(3);
  const bool round = random.index(2) == 0;
  const auto number = [&](double low, double high) {
    const double value = random.uniform(low, high);
    return round ? std::round(value * 64.0) / 64.0 : value;
  };
  const double mass = std::max(number(0.05, 5.0), 0.03125);
  const Vector3d half(std::max(number(0.02, 0.3), 0.03125), std::max(number(0.02, 0.3), 0.03125),
                      std::max(number(0.01, 0.2), 0.015625));
  const double yaw = random.index(2) == 0 ? 0.0 : random.uniform(0.0, 3.0);
  const Eigen::Matrix3d turned(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  const double dt = std::vector<double>{0.001, 0.01, 0.0625, 0.1}[random.index(4)];

  std::vector<Vector3d> corners;
  const bool polygon = random.index(3) == 0;
  for (int i = 0; i < n_c; ++i) {
    const double angle = 2.0 * M_PI * i / n_c;
    Vector3d r;
    if (polygon) {
      r = {half.x() * std::cos(angle), half.x() * std::sin(angle), -half.z()};
    } else if (i < 8) {  // four corners, then the middles of the sides
      r = i < 4 ? Vector3d((i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(), -half.z())
                : Vector3d(i < 6 ? (i == 4 ? 1 : -1) * half.x() : 0.0,
                           i < 6 ? 0.0 : (i == 6 ? 1 : -1) * half.y(), -half.z());
    } else {  // a corner twice, and the centre
      r = i == 8 ? Vector3d(half.x(), half.y(), -half.z()) : Vector3d(0.0, 0.0, -half.z());
    }
    corners.push_back(turned * r);
  }

  VectorXd v = VectorXd::Zero(6), u = VectorXd::Zero(3);
  switch (random.index(6)) {
    case 0:  // at rest
      break;
    case 1:  // sliding along an edge of the cone, or anywhere
      v[0] = number(-1.0, 1.0);
      if (random.index(2) == 0) v[1] = number(-1.0, 1.0);
      break;
    case 2:  // spinning in place
      v[5] = number(-3.0, 3.0);
      break;
    case 3:  // falling flat, or bouncing off
      v[2] = number(-2.0, 0.5);
      break;
    case 4:  // falling anyhow
      for (double& value : v) value = number(-1.0, 1.0);
      break;
    case 5:  // pushed from rest
      u[0] = number(-20.0, 20.0);
      u[1] = number(-20.0, 20.0);
      if (random.index(2) == 0) u[2] = number(-5.0, 5.0);
      break;
  }
  double height = 0.0, tilt_x = 0.0, tilt_y = 0.0;
  switch (random.index(5)) {
    case 0:
      height = number(-0.05, 0.05);
      break;
    case 1:
      tilt_x = number(-0.1, 0.1);
      tilt_y = random.index(2) == 0 ? 0.0 : number(-0.1, 0.1);
      break;
    case 2:  // what is left of 0 by rounding
      height = 1e-17 * random.uniform();
      tilt_x = 1e-16 * random.uniform();
      break;
    default:
      break;
  }
  const double one_mu = random.index(5) == 0 ? 0.0 : number(0.0, 1.5);
  const bool mu_differs = random.index(4) == 0;

  model::ContactSystem system;
  system.q = VectorXd::Zero(6);
  system.q[2] = half.z() + height;
  system.N_q = system.N_q_plus = Eigen::MatrixXd::Identity(6, 6);
  system.J_f_q = system.J_f_v = Eigen::MatrixXd::Zero(6, 6);
  const Vector3d inertia =
      mass / 3.0 *
      Vector3d(half.y() * half.y() + half.z() * half.z(), half.x() * half.x() + half.z() * half.z(),
               half.x() * half.x() + half.y() * half.y());
  system.M_inverse = Eigen::MatrixXd::Identity(6, 6) / mass;
  system.M_inverse.bottomRightCorner(3, 3) =
      turned * inertia.cwiseInverse().asDiagonal() * turned.transpose();
  system.J_f_u = system.M_inverse.leftCols(3);
  system.d_v = VectorXd::Zero(6);
  system.d_v[2] = -9.81;
  system.phi.resize(n_c);
  system.J_n.setZero(n_c, 6);
  system.J_t.setZero(n_c * n_e, 6);
  system.mu.resize(n_c);
  for (int i = 0; i < n_c; ++i) {
    const Vector3d& r = corners[static_cast<std::size_t>(i)];
    system.phi[i] = half.z() + height + r.z() + tilt_x * r.y() - tilt_y * r.x();
    system.mu[i] = mu_differs ? number(0.0, 1.5) : one_mu;
    const auto row = [&](const Vector3d& direction) {
      VectorXd jacobian(6);
      jacobian << direction, r.cross(direction);
      return jacobian.transpose().eval();
    };
    system.J_n.row(i) = row(Vector3d::UnitZ());
    for (int e = 0; e < n_e; ++e) {
      const double angle = 2.0 * M_PI * e / n_e;
      Vector3d edge(std::cos(angle), std::sin(angle), 0.0);
      if (n_e == 4 && round) edge = {std::round(edge.x()), std::round(edge.y()), 0.0};
      system.J_t.row(i * n_e + e) = row(turned * edge);
    }
  }
  ContactLcp problem;
  problem.lcs = model::stewart_trinkle(system, dt);
  problem.x.resize(12);
  problem.x << system.q, v;
  problem.u = u;
  const lcs::Lcs& l = problem.lcs;
  problem.F = l.F;
  problem.q = l.c + l.E * problem.x + l.H * u;
  problem.terms =
      l.c.cwiseAbs() + l.E.cwiseAbs() * problem.x.cwiseAbs() + l.H.cwiseAbs() * u.cwiseAbs();
  return problem;
}

}  // namespace c3rt::support
