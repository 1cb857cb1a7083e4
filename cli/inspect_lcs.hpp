#pragma once
// What `c3rt lcs inspect` looks at, and the Python package: a MuJoCo model's LCS where the file
// puts it.
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cli/inspect.hpp"
#include "controller/lcs/lcs.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/contact_model.hpp"
#include "controller/model/mechanism_model.hpp"
#include "controller/model/planning_model.hpp"

namespace c3rt::cli {

constexpr double kInspectedGoal = 0.1;  // how far a problem's target lies [m], [rad]

/// The LCS, and a problem that it can be tried with.
struct Seen {
  lcs::Lcs lcs;
  std::vector<std::string> names;  // of each entry of x, "" where it has none
  Eigen::VectorXd x0;
  Eigen::VectorXd Q, x_desired;  // Q: the diagonal
  Eigen::VectorXd u_min, u_max;  // ±infinity: none
};

struct SeenObjects : Seen {
  std::vector<mjcf::ObjectFile> files;
  std::unique_ptr<model::PlanningModel> model;
  scene::Scene scene;
  std::vector<int> contacts;
  model::ContactModel contact_model;
  model::ContactSystem system;
};

struct SeenMechanism : Seen {
  std::unique_ptr<model::MechanismModel> model;
  model::ContactSystem system;
  std::string goal;                // what is to be moved, by name
  std::vector<std::string> notes;  // what a person should know
};

/// Whether any of the files has motors. @throws UsageError for one that MuJoCo refuses
bool has_motors(const InspectSettings& settings);

/// @throws UsageError for a model that cannot be planned with, or what it cannot be asked
SeenObjects see_objects(const InspectSettings& settings);
SeenMechanism see_mechanism(const InspectSettings& settings);

/// The problem for `c3rt solve`, by C3+: every object, or else a joint, is to move by
/// kInspectedGoal.
std::string problem_file(const Seen& of);

}  // namespace c3rt::cli
