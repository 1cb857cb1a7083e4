#pragma once

#include "config/section.hpp"
#include "controller/c3/solver.hpp"

namespace c3rt::c3 {

/// The keys of a `c3` section; what is no number of the algorithm (δ⁰, fixed λ_0, traces) is left
/// to the caller. @throws config::ConfigError
Settings load_settings(config::Section section);

}  // namespace c3rt::c3
