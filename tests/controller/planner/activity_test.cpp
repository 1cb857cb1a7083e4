#include "controller/planner/activity.hpp"

#include <set>

#include <catch2/catch.hpp>

using namespace c3rt::planner;
using Catch::Contains;

namespace {

Parameters parameters() {
  Parameters p{};
  p.approach.reach_min = {0.35, -0.3};
  p.approach.reach_max = {0.75, 0.3};
  return p;
}

Activity holding(Cause cause) {
  Activity activity;
  activity.mode = Mode::kHold;
  activity.cause = cause;
  activity.since = 10.0;
  activity.age = 0.7;
  activity.body_name = "ball";
  activity.body_at = {0.812, 0.1};
  activity.body_speed = 0.04;
  return activity;
}

std::string said(Cause cause) { return describe(holding(cause), parameters(), 11.2); }

}  // namespace

TEST_CASE("activity: each cause of holding has its own words, with the numbers that help") {
  CHECK(said(Cause::kBodyNotInView) == "holding: ball 0 is not in view since 1.2 s");
  CHECK(said(Cause::kVisionSilent) ==
        "holding: vision is silent: the last estimate of ball 0 is 0.7 s old");
  CHECK(said(Cause::kNoVision) == "holding: vision has not told of ball 0 yet");
  CHECK(said(Cause::kBodyOutOfReach) ==
        "holding: ball 0 is out of reach at (0.812, 0.100) m; reach is x 0.35 to 0.75, y -0.3 to "
        "0.3 m");
  CHECK_THAT(said(Cause::kAsked), Contains("asked to hold"));
  CHECK_THAT(said(Cause::kNotBroughtToRest),
             Contains("could not be brought to rest and rolls at 0.040 m/s"));
  CHECK_THAT(said(Cause::kStopped), Contains("recover ends it"));
  CHECK_THAT(said(Cause::kStateLate), Contains("robot/state is late by 0.7 s"));

  std::set<std::string> sentences;
  for (int cause = 0; cause <= static_cast<int>(Cause::kAtTarget); ++cause)
    sentences.insert(said(static_cast<Cause>(cause)));
  CHECK(sentences.size() == static_cast<std::size_t>(Cause::kAtTarget) + 1);
}

TEST_CASE("activity: a body is called by its name and its index") {
  Activity activity = holding(Cause::kBodyNotFinite);
  activity.body = 2;
  CHECK(describe(activity, parameters(), 11.2) == "holding: the estimate of ball 2 is not finite");
  activity.body_name = "ball 2";
  CHECK(describe(activity, parameters(), 11.2) == "holding: the estimate of ball 2 is not finite");
  activity.mode = Mode::kRest;
  activity.cause = Cause::kNone;
  activity.body_name = "box";
  CHECK(describe(activity, parameters(), 11.2) == "bringing box 2 to rest");
}

TEST_CASE("activity: its ordinary work has one word, and needs nobody") {
  Activity activity = holding(Cause::kNone);
  activity.mode = Mode::kTask;
  activity.phase = "roll";
  CHECK(describe(activity, parameters(), 11.2) == "roll");
  CHECK_FALSE(needs_attention(activity));
  CHECK_FALSE(needs_attention(holding(Cause::kAsked)));
  CHECK(needs_attention(holding(Cause::kBodyOutOfReach)));
  CHECK(needs_attention(holding(Cause::kNotBroughtToRest)));
}
