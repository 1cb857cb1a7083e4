#pragma once

#include <optional>
#include <vector>

#include "controller/horizon/condensed.hpp"

namespace c3rt::horizon {

/// Which side of each pair is zero, in the order of the pairs.
enum class Side : char { kForce, kGap };

/// The best plan with these modes: zero sides are exactly zero up to rounding, the other sides and
/// the constraints hold. Nothing if these modes cannot be met, or the QP could not be solved.
std::optional<Plan> solve_modes(const Problem& problem, const Condensed& condensed,
                                const std::vector<Side>& zero);

/// The modes of a trajectory: the smaller side of each pair.
std::vector<Side> modes(const Problem& problem, const Plan& plan);

}  // namespace c3rt::horizon
