#pragma once

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"

namespace c3rt::lcs {

/// The system under a servo u_k = K (r_{k+1} − x_{k+1}) that looks at the end of the step, where a
/// law that looks at its beginning is unstable as soon as it is stiff for the step. With
/// G = (I + K B)⁻¹ K and w_k = G r_{k+1} it is a system of the same form with input w:
///
///   x⁺ = (A − B G A) x + B w + (D − B G D) λ + (d − B G d)
///   0 ≤ λ ⊥ (E − H G A) x + (F − H G D) λ + H w + (c − H G d) ≥ 0
///
/// @param K  (n_u × n_x) of the servo
/// @param closed, G  are overwritten
void close_loop(const Lcs& lcs, const Eigen::MatrixXd& K, Lcs& closed, Eigen::MatrixXd& G);

}  // namespace c3rt::lcs
