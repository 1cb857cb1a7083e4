#pragma once
// `c3rt lcs inspect` of a model with motors.
#include "cli/inspect.hpp"

namespace c3rt::cli {

/// As `inspect`, of one file that has motors: coordinates, motors, bodies, contacts and the rest,
/// where the file puts it. @throws UsageError for what it cannot be asked
int inspect_mechanism(const InspectSettings& settings);

}  // namespace c3rt::cli
