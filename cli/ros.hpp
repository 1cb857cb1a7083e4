#pragma once
// `c3rt ros`: the border to ROS 2.
#include <cstdint>
#include <optional>
#include <string>

#include "cli/python_program.hpp"

namespace c3rt::cli {

struct RosSettings {
  ShownScenario shown;
  std::optional<std::uint32_t> domain;  // ROS 2's; nothing: ROS_DOMAIN_ID, else 0
  std::string frame = "panda_link0";
  double rate_hz = 100.0;
};

/// Becomes the Python package's c3rt.ros; it ends with Ctrl-C. @throws UsageError as view(), for
/// what ROS_DOMAIN_ID cannot be, and where both domains are the same
int ros(const Seat& seat, const RosSettings& settings);

}  // namespace c3rt::cli
