#pragma once
// Of the stub: robot.h.
#include <stdexcept>
#include <vector>

#include <franka/robot.h>

namespace franka {

struct Record {
  RobotState state;
};
struct Exception : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct ControlException : Exception {
  using Exception::Exception;
  const std::vector<Record> log;
};
struct CommandException : Exception {
  using Exception::Exception;
};

}  // namespace franka
