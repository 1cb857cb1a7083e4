#pragma once
// A problem file's method MIQP15.
#include "config/problem_file.hpp"
#include "controller/horizon/search.hpp"

namespace c3rt::cli {

struct MonolithicAnswer {
  config::ProblemResult result;
  bool found;    // a plan
  bool decided;  // whether there is one
};

/// (15) by the exact search over the horizon; big-M has no part in it.
MonolithicAnswer solve_monolithic(const config::ProblemFile& problem, const c3::Deadline& deadline);

}  // namespace c3rt::cli
