#pragma once
#include <memory>
#include <string>

#include "config/problem_file.hpp"

namespace c3rt::python {

/// A problem that is not changed once it was checked, so that solvers and results share it.
struct Problem {
  std::shared_ptr<const config::ProblemFile> file;
};

/// @throws config::ConfigError
Problem parse_problem(const std::string& text, const std::string& name);

}  // namespace c3rt::python
