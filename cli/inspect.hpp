#pragma once
// `c3rt lcs inspect`: what a planner sees of a MuJoCo model.
#include <optional>
#include <string>
#include <vector>

#include "cli/exit_status.hpp"

namespace c3rt::cli {

struct InspectSettings {
  std::vector<std::string> models;  // MJCF files, one object each; or one with motors
  // of contacts, by name; none: all there are. Of a model with motors
  // "FIRST,SECOND[,closest=N][,friction=MU]", by the names of bodies and geoms
  std::vector<std::string> pairs;
  std::string contact_model = "anitescu";
  double step = 0.05;            // Δt [s]
  std::vector<double> effector;  // from the first object's centre of mass [m]; none: beside it
  int support_points = 4;
  std::optional<int> directions;  // of friction at each contact of a model with motors; none: 2
  std::vector<double> across;     // of its first one, as model::MechanismParameters; none: none
  std::string out;                // file of the LCS as a problem of `c3rt solve`; none: not written
};

std::vector<std::string> inspect_pairs();

/// Prints bodies, contacts, sizes, conditioning, the error of each block and what a person should
/// mind. @return an exit status @throws UsageError for a model that cannot be planned with
int inspect(const InspectSettings& settings);

}  // namespace c3rt::cli
