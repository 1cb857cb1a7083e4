#pragma once
// What the four processes share of a scenario, whoever of them reads it.
#include "config/section.hpp"

namespace c3rt::config {

/// Who ends a standstill that lost messages alone have brought about (commands that the robot
/// missed, robot states that its controller missed), once they come steadily again.
enum class Recovery { kAutomatic, kByPerson };

struct Service {
  Recovery recovery;
};

/// Of a whole scenario. @throws ConfigError, also for a numerical example, which no process runs
Service load_service(Section& root);

}  // namespace c3rt::config
