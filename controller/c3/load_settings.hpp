#pragma once

#include "config/section.hpp"
#include "controller/c3/solver.hpp"

namespace c3rt::c3 {

/// The keys of a `c3` section; those of a projection or QP step that is not chosen need not be
/// there. What is no number of the algorithm (δ⁰, fixed λ_0, traces) is left to the caller. @throws
/// config::ConfigError
Settings load_settings(config::Section section);

}  // namespace c3rt::c3
