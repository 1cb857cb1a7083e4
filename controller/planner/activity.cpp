#include "controller/planner/activity.hpp"

#include "controller/base/words.hpp"

namespace c3rt::planner {
namespace {

using base::words;

/// "t 0", "box 0": as clients name it, by its index.
std::string called(const Activity& activity) {
  const std::string name = activity.body_name.c_str();
  const bool numbered = !name.empty() && name.back() >= '0' && name.back() <= '9';
  return numbered ? name : name + " " + std::to_string(activity.body);
}

std::string doing(const Activity& activity) {
  switch (activity.mode) {
    case Mode::kWait:
      return "waiting";
    case Mode::kApproach:
      return "approach";
    case Mode::kTask:
      return activity.phase;
    case Mode::kRest:
      return "bringing " + called(activity) + " to rest";
    case Mode::kHold:
      return "holding";
  }
  return "";
}

std::string why(const Activity& a, const Parameters& parameters, double now) {
  const ApproachParameters& reach = parameters.approach;
  const std::string name = called(a);
  const char* body = name.c_str();
  switch (a.cause) {
    case Cause::kNone:
      return {};
    case Cause::kNoState:
      return "no robot/state has arrived";
    case Cause::kStateLate:
      return words("robot/state is late by %.1f s", a.age);
    case Cause::kStateNotFinite:
      return "robot/state is not finite";
    case Cause::kNoVision:
      return words("vision has not told of %s yet", body);
    case Cause::kVisionSilent:
      return words("vision is silent: the last estimate of %s is %.1f s old", body, a.age);
    case Cause::kBodyNotInView:
      return words("%s is not in view since %.1f s", body, now - a.since);
    case Cause::kBodyNotFinite:
      return words("the estimate of %s is not finite", body);
    case Cause::kBodyOutOfReach:
      return words("%s is out of reach at (%.3f, %.3f) m; reach is x %g to %g, y %g to %g m", body,
                   a.body_at.x(), a.body_at.y(), reach.reach_min.x(), reach.reach_max.x(),
                   reach.reach_min.y(), reach.reach_max.y());
    case Cause::kStopped:
      return "stopped by a person; recover ends it";
    case Cause::kAsked:
      return words("asked to hold; %s at (%.3f, %.3f) m", body, a.body_at.x(), a.body_at.y());
    case Cause::kNotBroughtToRest:
      return words("asked to hold; %s could not be brought to rest and rolls at %.3f m/s", body,
                   a.body_speed);
    case Cause::kAtTarget:
      return words("%s lies at its target, (%.3f, %.3f) m", body, a.body_at.x(), a.body_at.y());
  }
  return {};
}

}  // namespace

const char* name(Mode mode, const char* phase) {
  switch (mode) {
    case Mode::kWait:
      return "wait";
    case Mode::kApproach:
      return "approach";
    case Mode::kTask:
      return phase;
    case Mode::kRest:
      return "rest";
    case Mode::kHold:
      return "hold";
  }
  return "";
}

bool needs_attention(const Activity& activity) {
  return activity.cause != Cause::kNone && activity.cause != Cause::kAsked &&
         activity.cause != Cause::kAtTarget;
}

std::string describe(const Activity& activity, const Parameters& parameters, double now) {
  const std::string cause = why(activity, parameters, now);
  return cause.empty() ? doing(activity) : doing(activity) + (": " + cause);
}

}  // namespace c3rt::planner
