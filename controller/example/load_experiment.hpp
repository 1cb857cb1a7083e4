#pragma once

#include "config/section.hpp"
#include "controller/example/experiment.hpp"

namespace c3rt::example {

/// The sections of an example's scenario (docs/scenarios.md): example, model, plant, control, c3,
/// weights, constraints, start, success. The caller finishes the root.
/// @throws config::ConfigError
Experiment load_experiment(config::Section root);

}  // namespace c3rt::example
