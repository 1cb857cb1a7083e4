#pragma once
// What the planner is doing and why, for a person.
#include <string>

#include <Eigen/Core>

#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// What the planner does; a ball that is lost or a state that is missing leads to kHold or kWait,
/// and back. kRest: the end effector stands on the ball until it lies still.
enum class Mode { kWait, kApproach, kRoll, kReturn, kRest, kHold };

/// Why it waits, holds or brings a ball to rest.
enum class Cause {
  kNone,       // it goes about its task
  kNoState,    // the robot's state has never been heard
  kStateLate,  // or is older than the timeout
  kStateNotFinite,
  kNoVision,       // vision has never spoken of the ball
  kVisionSilent,   // or last did so longer ago than the timeout
  kBallNotInView,  // vision says that it does not see it
  kBallNotFinite,
  kBallOutOfReach,
  kStopped,           // a person has stopped the robot
  kAsked,             // a client asks to hold
  kNotBroughtToRest,  // the same, but the ball could not be brought to rest first
  kAtTarget,          // the ball lies where a client wants it
};

struct Activity {
  Mode mode = Mode::kWait;
  Cause cause = Cause::kNoState;
  double since = 0.0;  // mode and cause have been these, session time [s]
  int ball = 0;        // that is meant
  double age = 0.0;    // of what is late; of a ball: since vision last spoke of it [s]
  Eigen::Vector2d ball_at = Eigen::Vector2d::Zero();  // in W [m]
  double ball_speed = 0.0;                            // [m/s]
};

/// Whether somebody should look: it cannot go about its task, and nobody asked for that.
bool needs_attention(const Activity& activity);

/// A sentence: "holding: ball 0 is not in view since 1.2 s".
std::string describe(const Activity& activity, const Parameters& parameters, double now);

}  // namespace c3rt::planner
