#pragma once

#include <optional>
#include <vector>

#include "controller/horizon/condensed.hpp"

namespace c3rt::horizon {

/// The best plan with these modes: zero sides are exactly zero up to rounding, the other sides and
/// the constraints hold (`residual` is at most kMet). Nothing if these modes cannot be met, or the
/// QP could not be solved.
std::optional<Plan> solve_modes(const Problem& problem, const std::vector<Side>& zero);

/// The same from a QP in the middle of a search, with its centre; both are used up.
std::optional<Plan> solve_modes(const Problem& problem, const std::vector<Side>& zero,
                                const Condensed& condensed, const LeastDistance& least,
                                qp::NodeQp& qp, LeastDistance::Centre& centre);

/// The modes of a trajectory: the smaller side of each pair.
std::vector<Side> modes(const Problem& problem, const Plan& plan);

}  // namespace c3rt::horizon
