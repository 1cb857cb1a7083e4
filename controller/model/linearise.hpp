#pragma once
// Derivatives of a robot's smooth dynamics by automatic differentiation.
#include <stdexcept>
#include <string>

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include "controller/model/contact_system.hpp"

namespace c3rt::model {

/// A number that carries its derivatives by [q; v; u].
using Differentiable = Eigen::AutoDiffScalar<Eigen::VectorXd>;

template <typename Scalar>
using VectorOf = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

/// Fills `system`'s q, J_f_q, J_f_v, J_f_u and d_v with f = M⁻¹ (B u − C) and its exact Jacobian at
/// (q, v, u) [C3, eq. (8)]; the other blocks stay.
///
/// @param f callable for Scalar = Differentiable: f(VectorOf<Scalar> q, v, u) gives the
///          accelerations (n_v); usually a lambda with `auto` parameters
/// @throws std::invalid_argument if f does not give n_v numbers
template <typename Dynamics>
void linearise(const Dynamics& f, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
               const Eigen::VectorXd& u, ContactSystem& system) {
  const Eigen::Index n_q = q.size(), n_v = v.size(), n_u = u.size(), n = n_q + n_v + n_u;
  const auto seeded = [n](const Eigen::VectorXd& values, Eigen::Index first) {
    VectorOf<Differentiable> result(values.size());
    for (Eigen::Index i = 0; i < values.size(); ++i)
      result[i] = Differentiable(values[i], Eigen::VectorXd::Unit(n, first + i));
    return result;
  };
  const VectorOf<Differentiable> acceleration =
      f(seeded(q, 0), seeded(v, n_q), seeded(u, n_q + n_v));
  if (acceleration.size() != n_v)
    throw std::invalid_argument("dynamics: expected " + std::to_string(n_v) +
                                " accelerations, got " + std::to_string(acceleration.size()));

  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n_v, n);
  Eigen::VectorXd value(n_v);
  for (Eigen::Index i = 0; i < n_v; ++i) {
    value[i] = acceleration[i].value();
    // a constant carries no derivatives at all
    if (acceleration[i].derivatives().size() == n) J.row(i) = acceleration[i].derivatives();
  }
  system.q = q;
  system.J_f_q = J.leftCols(n_q);
  system.J_f_v = J.middleCols(n_q, n_v);
  system.J_f_u = J.rightCols(n_u);
  system.d_v = value - system.J_f_q * q - system.J_f_v * v - system.J_f_u * u;
}

}  // namespace c3rt::model
