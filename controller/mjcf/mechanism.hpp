#pragma once
// A mechanism with motors, and free bodies, from a MuJoCo model (MJCF).
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/mjcf/error.hpp"
#include "controller/scene/mechanism.hpp"

namespace c3rt::mjcf {

struct MechanismFile {
  std::shared_ptr<scene::Mechanism> mechanism;
  std::vector<std::string> notes;  // what a person should know: what is left out, what was assumed
};

/// Whether a file has actuators, which an object's has not. @throws Error where MuJoCo refuses it
bool has_actuators(const std::string& file);

/// Hinges, slides and free joints with motors at hinges and slides; what surfaces there are, the
/// world's planes as well. Mass matrix, bias and their derivatives are MuJoCo's of a copy without
/// contacts and limits. It is at home in the file's first keyframe, else as the file places it.
/// @throws Error naming what the file has that no plan knows of: tendons, equalities, ball joints,
/// friction of a joint, actuators that are no motors of a hinge or slide, height fields and
/// ellipsoids that collide, mocap bodies; where there is no motor
MechanismFile read_mechanism(const std::string& file);

}  // namespace c3rt::mjcf
