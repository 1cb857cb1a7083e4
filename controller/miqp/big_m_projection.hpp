#pragma once

#include <memory>

#include "controller/c3/projection.hpp"
#include "controller/miqp/solver.hpp"

namespace c3rt::miqp {

/// The projection (23) as the paper's tables time it: big-M, a general MIQP solver, built anew each
/// time. For comparisons only: it allocates, takes milliseconds, and leaks complementarity of the
/// size (integer tolerance) × M. Ignores the deadline. kSolved: within the solver's gap.
std::unique_ptr<c3::Projection> make_big_m_projection(const c3::Sizes& sizes, double big_m,
                                                      const Settings& settings);

}  // namespace c3rt::miqp
