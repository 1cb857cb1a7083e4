#pragma once

#include <Eigen/Core>

namespace c3rt::lcs {

/// The stabilising solution P of the discrete algebraic Riccati equation, the terminal weight of
/// the horizon in the cart-pole example [C3, section VI-C]:
///
///   P = Q + Aᵀ P A − Aᵀ P B (R + Bᵀ P B)⁻¹ Bᵀ P A
///
/// By the structure-preserving doubling algorithm; P is symmetric.
/// @param Q symmetric positive semidefinite (n_x × n_x)
/// @param R symmetric positive definite (n_u × n_u)
/// @throws std::invalid_argument if a shape is wrong or R not positive definite,
///         std::runtime_error if the iteration does not converge (a mode that is unstable and
///         uncontrollable, or on the unit circle and unseen by Q)
Eigen::MatrixXd riccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                        const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R);

}  // namespace c3rt::lcs
