#pragma once
// `c3rt lcs inspect`: what a planner sees of a MuJoCo model.
#include <string>
#include <vector>

#include "cli/exit_status.hpp"

namespace c3rt::cli {

struct InspectSettings {
  std::vector<std::string> models;  // MJCF files, one object each
  std::vector<std::string> pairs;   // of contacts, by name; none: all there are
  std::string contact_model = "anitescu";
  double step = 0.05;            // Δt [s]
  std::vector<double> effector;  // from the first object's centre of mass [m]; none: beside it
  int support_points = 4;
  std::string out;  // file of the LCS as a problem of `c3rt solve`; none: not written
};

std::vector<std::string> inspect_pairs();

/// Prints bodies, contacts, sizes, conditioning, the error of each block and what a person should
/// mind. @return an exit status @throws UsageError for a model that cannot be planned with
int inspect(const InspectSettings& settings);

}  // namespace c3rt::cli
