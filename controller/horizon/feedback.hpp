#pragma once

#include <vector>

#include <Eigen/Core>

#include "controller/horizon/problem.hpp"

namespace c3rt::horizon {

/// Which side of each pair is zero, in the order of the pairs (stage by stage).
enum class Side : char { kForce, kGap };

/// Gains K_k (n_u + n_lambda × n_x) with which x_{k+1} = (A + [B D] K_k) x_k + … does not grow
/// where that can be had: a linear-quadratic regulator, forces being much dearer than inputs, so
/// that they take part only in what inputs cannot stabilise. Without it the condensed problem and
/// every roll-out lose a digit for each tenfold growth of an unstable system.
/// @param zero  the modes that the plan will have, which change what the system does; or empty
std::vector<Eigen::MatrixXd> stabilising_feedback(const Problem& problem,
                                                  const std::vector<Side>& zero = {});

}  // namespace c3rt::horizon
