#include "controller/planner/activity.hpp"

#include <cstdio>

namespace c3rt::planner {
namespace {

template <typename... Numbers>
std::string text(const char* format, Numbers... numbers) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, numbers...);
  return buffer;
}

const char* doing(Mode mode) {
  switch (mode) {
    case Mode::kWait:
      return "waiting";
    case Mode::kApproach:
      return "approach";
    case Mode::kRoll:
      return "roll";
    case Mode::kReturn:
      return "return";
    case Mode::kRest:
      return "bringing the ball to rest";
    case Mode::kHold:
      return "holding";
  }
  return "";
}

std::string why(const Activity& a, const Parameters& parameters, double now) {
  const ApproachParameters& reach = parameters.approach;
  switch (a.cause) {
    case Cause::kNone:
      return {};
    case Cause::kNoState:
      return "no robot/state has arrived";
    case Cause::kStateLate:
      return text("robot/state is late by %.1f s", a.age);
    case Cause::kStateNotFinite:
      return "robot/state is not finite";
    case Cause::kNoVision:
      return text("vision has not told of ball %d yet", a.ball);
    case Cause::kVisionSilent:
      return text("vision is silent: the last estimate of ball %d is %.1f s old", a.ball, a.age);
    case Cause::kBallNotInView:
      return text("ball %d is not in view since %.1f s", a.ball, now - a.since);
    case Cause::kBallNotFinite:
      return text("the estimate of ball %d is not finite", a.ball);
    case Cause::kBallOutOfReach:
      return text("ball %d is out of reach at (%.3f, %.3f) m; reach is x %g to %g, y %g to %g m",
                  a.ball, a.ball_at.x(), a.ball_at.y(), reach.reach_min.x(), reach.reach_max.x(),
                  reach.reach_min.y(), reach.reach_max.y());
    case Cause::kStopped:
      return "stopped by a person; recover ends it";
    case Cause::kAsked:
      return text("asked to hold; ball %d at (%.3f, %.3f) m", a.ball, a.ball_at.x(), a.ball_at.y());
    case Cause::kNotBroughtToRest:
      return text("asked to hold; ball %d could not be brought to rest and rolls at %.3f m/s",
                  a.ball, a.ball_speed);
    case Cause::kAtTarget:
      return text("ball %d lies at its target, (%.3f, %.3f) m", a.ball, a.ball_at.x(),
                  a.ball_at.y());
  }
  return {};
}

}  // namespace

bool needs_attention(const Activity& activity) {
  return activity.cause != Cause::kNone && activity.cause != Cause::kAsked &&
         activity.cause != Cause::kAtTarget;
}

std::string describe(const Activity& activity, const Parameters& parameters, double now) {
  const std::string cause = why(activity, parameters, now);
  return cause.empty() ? doing(activity.mode) : doing(activity.mode) + (": " + cause);
}

}  // namespace c3rt::planner
