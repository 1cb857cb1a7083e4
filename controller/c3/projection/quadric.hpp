#pragma once

#include <Eigen/Core>

namespace c3rt::c3 {

/// The QCQP with one constraint
///
///   min ‖h − a‖²   subject to   q_0 + gᵀ h + hᵀ diag(curvature) h = 0
///
/// by bisection on its multiplier ν [17, appendix B]: h = a − ν b / (2 (1 + ν curvature)) with b =
/// g + 2 curvature a, and the constraint falls monotonically in ν where 1 + ν curvature > 0; at the
/// end of that interval the direction of the extreme curvature takes what is left.
/// @param h  not `a`
/// Returns what is left of the constraint: not 0 only if it has no zero.
/// RT: no heap, no lock, no throw.
double nearest_on_quadric(double q_0, const Eigen::VectorXd& g, const Eigen::VectorXd& curvature,
                          const Eigen::VectorXd& a, Eigen::VectorXd& h) noexcept;

}  // namespace c3rt::c3
