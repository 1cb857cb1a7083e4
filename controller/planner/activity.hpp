#pragma once
// What the planner is doing and why, for a person.
#include <string>

#include <Eigen/Core>

#include "controller/planner/parameters.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

/// What the planner does; a body that is lost or a state that is missing leads to kHold or kWait,
/// and back. kTask: it is in a phase of its strategy. kRest: the end effector stands on a rolling
/// body until it lies still.
enum class Mode { kWait, kApproach, kTask, kRest, kHold };

/// Why it waits, holds or brings a body to rest.
enum class Cause {
  kNone,       // it goes about its task
  kNoState,    // the robot's state has never been heard
  kStateLate,  // or is older than the timeout
  kStateNotFinite,
  kNoVision,       // vision has never spoken of the body
  kVisionSilent,   // or last did so longer ago than the timeout
  kBodyNotInView,  // vision says that it does not see it
  kBodyNotFinite,
  kBodyOutOfReach,
  kStopped,           // a person has stopped the robot
  kAsked,             // a client asks to hold
  kNotBroughtToRest,  // the same, but the body could not be brought to rest first
  kAtTarget,          // the body lies where a client wants it
};

struct Activity {
  Mode mode = Mode::kWait;
  const char* phase = "";  // of the strategy, in kTask; lives for ever
  Cause cause = Cause::kNoState;
  double since = 0.0;  // mode and cause have been these, session time [s]
  int body = 0;        // that is meant
  scene::Name body_name = {};
  double age = 0.0;  // of what is late; of a body: since vision last spoke of it [s]
  Eigen::Vector2d body_at = Eigen::Vector2d::Zero();  // in W [m]
  double body_speed = 0.0;                            // [m/s]
};

/// "approach"; of kTask the strategy's own word is meant.
const char* name(Mode mode, const char* phase);

/// Whether somebody should look: it cannot go about its task, and nobody asked for that.
bool needs_attention(const Activity& activity);

/// A sentence: "holding: box 0 is not in view since 1.2 s".
std::string describe(const Activity& activity, const Parameters& parameters, double now);

}  // namespace c3rt::planner
