#pragma once
// The kinds of tasks by name: a new one is a file of its own and its name in this room's
// CMakeLists.txt.
#include "controller/task/request.hpp"
#include "controller/task/source.hpp"
#include "controller/task/task.hpp"

namespace c3rt::task {

/// The names of all kinds.
std::vector<std::string> kinds();

/// The task that a source describes: its parameter `kind` names which.
Task load(Source& source);

/// The same of a client's.
/// @throws RequestError naming what was expected and what came
Task load(const Request& request);

}  // namespace c3rt::task
