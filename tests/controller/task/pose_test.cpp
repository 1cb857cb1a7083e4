#include "controller/task/pose.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "controller/task/registry.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::task;
using Catch::Contains;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Parameters = std::vector<Parameter>;

const Parameters kDrawn{{"random_goals", {100}, ""},
                        {"random_x_m", {0.4, 0.6}, ""},
                        {"random_y_m", {-0.15, 0.1}, ""},
                        {"random_yaw_rad", {-3.0, 1.0}, ""},
                        {"position_tolerance_m", {0.02}, ""},
                        {"angle_tolerance_rad", {0.1}, ""},
                        {"hold_s", {1.0}, ""}};
const Parameters kPlaced{{"goals_m", {0.5, 0.1, 0.6, -0.1}, ""},
                         {"position_tolerance_m", {0.02}, ""},
                         {"hold_s", {1.0}, ""}};

/// These, with others in their place or beside them; one without a value is taken out.
Request request(Parameters parameters, const Parameters& other = {}) {
  for (const Parameter& one : other) {
    parameters.erase(std::remove_if(parameters.begin(), parameters.end(),
                                    [&](const Parameter& old) { return old.name == one.name; }),
                     parameters.end());
    if (!one.values.empty() || !one.word.empty()) parameters.push_back(one);
  }
  return {"pose", std::move(parameters)};
}

Pose pose(const Parameters& parameters, const Parameters& other = {}) {
  return *load(request(parameters, other)).as<Pose>();
}

std::string said(const Parameters& parameters, const Parameters& other) {
  try {
    (void)load(request(parameters, other));
    return "taken";
  } catch (const RequestError& error) {
    return error.what();
  }
}

Placement turned(double x, double y, const Eigen::Quaterniond& q) { return {Vector2d(x, y), q}; }

Eigen::Quaterniond about(const Vector3d& axis, double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

bool same(const Pose& a, const Pose& b) {
  return std::equal(a.goals.begin(), a.goals.end(), b.goals.begin(), b.goals.end(),
                    [](const PoseGoal& left, const PoseGoal& right) {
                      return left.at == right.at && left.yaw == right.yaw;
                    });
}

scene::Scene with(const Placement& body) {
  scene::Scene scene;
  scene.body_count = 1;
  scene.body(0).p_WB << body.at, 0.0;
  scene.body(0).q_WB = body.q;
  return scene;
}

}  // namespace

TEST_CASE("pose: goals are drawn evenly in the rectangle and the range of yaws") {
  const Pose drawn = pose(kDrawn, {{"random_goals", {1000}, ""}}).seeded(3);
  REQUIRE(drawn.goals.size() == 1000);
  const Vector3d min(0.4, -0.15, -3.0), max(0.6, 0.1, 1.0);
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const PoseGoal& goal : drawn.goals) {
    const Vector3d share =
        (Vector3d(goal.at.x(), goal.at.y(), *goal.yaw) - min).array() / (max - min).array();
    REQUIRE((share.array() >= 0.0).all());
    REQUIRE((share.array() <= 1.0).all());
    sum += share;
    squares += share.cwiseAbs2();
    CHECK(goal.position_tolerance == 0.02);
    CHECK(goal.angle_tolerance == 0.1);
    CHECK(goal.hold == 1.0);
  }
  // mean 1/2 and mean square 1/3, within five standard deviations of a thousand draws
  for (int i = 0; i < 3; ++i) {
    CHECK(sum[i] / 1000.0 == Approx(0.5).margin(5.0 * std::sqrt(1.0 / 12.0 / 1000.0)));
    CHECK(squares[i] / 1000.0 == Approx(1.0 / 3.0).margin(5.0 * std::sqrt(4.0 / 45.0 / 1000.0)));
  }
}

TEST_CASE("pose: a seed decides what is drawn, and fewer goals are the first of more") {
  const Task task = load(request(kDrawn));
  const auto drawn = [&](std::uint64_t seed) { return *task.seeded(seed).as<Pose>(); };
  CHECK(same(drawn(7), drawn(7)));
  CHECK_FALSE(same(drawn(7), drawn(8)));
  CHECK(same(*task.as<Pose>(), drawn(1)));  // a run that nobody gives a seed has this one
  CHECK(same(*task.seeded(8).seeded(7).as<Pose>(), drawn(7)));
  const Pose few = pose(kDrawn, {{"random_goals", {3}, ""}}).seeded(7);
  REQUIRE(few.goals.size() == 3);
  CHECK(few.goals[2].at == drawn(7).goals[2].at);
  CHECK(few.goals[2].yaw == drawn(7).goals[2].yaw);
  // without a range of yaws however it is turned
  const Pose round = pose(kDrawn, {{"random_yaw_rad", {}, ""}, {"angle_tolerance_rad", {}, ""}});
  CHECK_FALSE(round.goals[0].yaw);
}

TEST_CASE("task: one that draws nothing is itself, whatever the seed") {
  const Task task = load(request(kPlaced));
  CHECK(same(*task.seeded(7).as<Pose>(), *task.as<Pose>()));
  const Task circle = load(Request{
      "circle", {{"center_m", {0.5, 0.0}, ""}, {"radius_m", {0.1}, ""}, {"lead_rad", {0.3}, ""}}});
  CHECK(circle.seeded(7).is(circle));
}

TEST_CASE("pose: what contradicts itself is refused by name") {
  CHECK(said(kDrawn, {}) == "taken");
  CHECK_THAT(said(kDrawn, {{"goals_m", {0.5, 0.0}, ""}}),
             Contains("random_goals: expected no goals_m"));
  CHECK_THAT(said(kDrawn, {{"yaws_rad", {0.5}, ""}}),
             Contains("random_goals: expected no yaws_rad"));
  CHECK_THAT(said(kDrawn, {{"random_goals", {0}, ""}}), Contains("random_goals"));
  CHECK_THAT(said(kDrawn, {{"random_goals", {1001}, ""}}), Contains("from 1 to 1000"));
  CHECK_THAT(said(kDrawn, {{"random_goals", {2.5}, ""}}),
             Contains("random_goals: expected whole numbers, got 2.5"));
  CHECK_THAT(said(kDrawn, {{"random_y_m", {}, ""}}), Contains("random_y_m"));
  CHECK_THAT(said(kDrawn, {{"random_x_m", {0.6, 0.4}, ""}}),
             Contains("random_x_m: expected the smaller one first"));
  CHECK_THAT(said(kPlaced, {{"random_x_m", {0.4, 0.6}, ""}}), Contains("random_x_m"));
  CHECK_THAT(said(kPlaced, {{"time_limit_s", {0.0}, ""}}), Contains("time_limit_s"));
  CHECK_THAT(said(kPlaced, {{"axis", {}, "w"}, {"angle_tolerance_rad", {0.1}, ""}}),
             Contains("axis: expected one of x, y, z"));
  CHECK_THAT(said(kPlaced, {{"axis", {}, "x"}}), Contains("angle_tolerance_rad"));
  const Parameters axis{{"axis", {}, "x"}, {"angle_tolerance_rad", {0.1}, ""}};
  const auto with_axis = [&](Parameter other) {
    Parameters all = axis;
    all.push_back(std::move(other));
    return all;
  };
  CHECK(said(kPlaced, axis) == "taken");
  CHECK(said(kPlaced, with_axis({"yaws_rad", {0.5}, ""})) == "taken");
  CHECK(said(kPlaced, with_axis({"axis_to", {0, 0, 1}, ""})) == "taken");
  CHECK_THAT(said(kPlaced, with_axis({"axis_to", {0, 0, 0}, ""})),
             Contains("axis_to: expected directions"));
  CHECK_THAT(said(kPlaced, {{"axis_to", {0, 0, 1}, ""}}), Contains("axis_to"));
  Parameters both = with_axis({"yaws_rad", {0.5}, ""});
  both.push_back({"axis_to", {0, 0, 1}, ""});
  CHECK_THAT(said(kPlaced, both), Contains("axis_to: expected no yaws_rad beside it"));
}

TEST_CASE("pose: a client's drawn goals have to lie within reach, whatever the seed") {
  const Limits wide{1, {Vector2d(0.4, -0.15), Vector2d(0.6, 0.1)}},
      narrow{1, {Vector2d(0.4, -0.15), Vector2d(0.6, 0.09)}};
  CHECK(pose(kDrawn).refusal(wide).empty());
  CHECK_THAT(pose(kDrawn, {{"random_goals", {1}, ""}}).refusal(narrow),
             Contains("expected a goal with x in [0.4, 0.6]") && Contains("got (0.6, 0.1)"));
  CHECK_THAT(pose(kDrawn).describe(), Contains("100 poses drawn in x 0.4 to 0.6"));
}

TEST_CASE("pose: a goal that is not reached in its time is missed, and the next one begins") {
  const Pose task = pose(kPlaced, {{"time_limit_s", {5.0, 3.0}, ""}});
  State state;
  state.since = 10.0;  // the task begins
  const Placement away(0.0, 0.0), first(0.5, 0.1);
  const auto at = [&](double time, const Placement& body) {
    task.advance(time, {body}, state);
    return std::pair<int, int>(state.goal, state.missed);
  };
  using Counts = std::pair<int, int>;
  CHECK(at(14.9, away) == Counts(0, 0));
  CHECK(at(14.95, first) == Counts(0, 0));
  CHECK(at(15.9, first) == Counts(0, 0));  // it came in time, and is given the time to stay
  CHECK(at(15.95, first) == Counts(1, 0));
  CHECK(at(18.9, away) == Counts(1, 0));  // the second one's time runs since then
  CHECK(at(18.96, away) == Counts(2, 1));
  CHECK(task.done(state));
  // one that has come and gone is missed, too
  State other;
  other.since = 0.0;
  task.advance(4.5, {first}, other);
  task.advance(5.1, {away}, other);
  CHECK(other.goal == 1);
  CHECK(other.missed == 1);
}

TEST_CASE("pose: no time runs before the task begins, nor where there is no limit") {
  const Placement away(0.0, 0.0);
  State state;
  pose(kPlaced, {{"time_limit_s", {5.0}, ""}}).advance(1e6, {away}, state);
  CHECK(state.goal == 0);
  State begun;
  begun.since = 0.0;
  pose(kPlaced).advance(1e6, {away}, begun);
  CHECK(begun.goal == 0);
}

TEST_CASE(
    "pose: goals that are due together have the longest of their times, and are missed together") {
  const Pose task = pose(kPlaced, {{"object", {0, 1}, ""}, {"time_limit_s", {2.0, 7.0}, ""}});
  State state;
  state.since = 0.0;
  const std::vector<Placement> one_there{{0.5, 0.1}, {0.0, 0.0}};
  task.advance(6.9, one_there, state);
  CHECK(state.goal == 0);
  task.advance(7.0, one_there, state);
  CHECK(state.goal == 2);
  CHECK(state.missed == 2);
}

TEST_CASE("progress: of goals in turn it tells reached and missed ones, and their times") {
  const auto progress = Task(pose(kPlaced, {{"goals_m", {0.5, 0.1, 0.6, -0.1, 0.5, 0.0}, ""},
                                            {"time_limit_s", {10.0}, ""}}))
                            .progress();
  const auto result = [&](const std::string& name) {
    for (const auto& [key, value] : progress->results()) {
      if (key == name) return value;
    }
    return -1.0;
  };
  progress->add(0.0, {{0.0, 0.0}});
  CHECK(std::isnan(result("goal_time_median_s")));
  progress->add(3.0, {{0.5, 0.1}});
  progress->add(4.0, {{0.5, 0.1}});
  CHECK(result("goals_reached") == 1.0);
  progress->add(14.0, {{0.5, 0.1}});  // the second one's ten seconds are over
  CHECK(result("goals_reached") == 1.0);
  CHECK(result("goals_missed") == 1.0);
  CHECK(progress->amount() == 1.0);
  progress->add(20.0, {{0.5, 0.0}});
  CHECK(progress->completed() == 0);
  progress->add(21.0, {{0.5, 0.0}});
  CHECK(progress->completed() == 1);
  CHECK(result("goals_reached") == 2.0);
  CHECK(result("goal_time_s") == 21.0);
  CHECK(result("goal_time_median_s") == 4.0);  // of 4 and 7 s, by nearest rank
  CHECK(result("goal_time_longest_s") == 7.0);
  for (const auto& [key, value] : progress->results()) {
    const auto names = Pose::criteria();
    CHECK(std::find(names.begin(), names.end(), key) != names.end());
  }
}

TEST_CASE("pose: noise of what is sensed makes no goal of several look done before it is") {
  const auto goals_done = [](const Pose& task, double off) {
    State state;
    const scene::Scene scene = with({0.5 + off, 0.1});
    task.advance(0.0, scene, state);
    task.advance(1.0, scene, state);
    return state.goal;
  };
  const Pose several = pose(kPlaced), one = pose(kPlaced, {{"goals_m", {0.5, 0.1}, ""}});
  CHECK(goals_done(several, 0.0159) == 1);
  CHECK(goals_done(several, 0.0161) == 0);
  CHECK(goals_done(one, 0.0199) == 1);
  // the truth needs no margin
  State state;
  several.advance(0.0, {{0.5199, 0.1}}, state);
  several.advance(1.0, {{0.5199, 0.1}}, state);
  CHECK(state.goal == 1);
}

TEST_CASE("pose: of an axis only its direction counts, however the body is turned about it") {
  for (int i = 0; i < test::property_instances(); ++i) {
    CAPTURE(i);
    support::Random random(i);
    const auto uniform = [&](double from, double to) { return random.uniform(from, to); };
    const Vector3d to = Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    const char* names[] = {"x", "y", "z"};
    const int of = i % 3;
    const Vector3d axis = Vector3d::Unit(of);
    const Pose task =
        pose(kPlaced, {{"axis", {}, names[of]},
                       {"axis_to", {2 * to.x() / 3, 2 * to.y() / 3, 2 * to.z() / 3}, ""},
                       {"angle_tolerance_rad", {0.1}, ""}});
    // off by a known angle about an axis across, then turned about the body's own axis
    const double off = uniform(0, M_PI), own = uniform(-M_PI, M_PI);
    Vector3d across = to.cross(Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
    const Eigen::Quaterniond q = about(across, off) * support::turn(axis, to) * about(axis, own);
    CHECK(task.angle_error(task.goals[0], turned(0.5, 0.1, q)) == Approx(off).margin(1e-7));
    // about z nothing brings it nearer than what the strategy turns it by
    scene::Scene scene = with(turned(0.5, 0.1, q));
    const auto error_after = [&](double turn) {
      return task.angle_error(task.goals[0], turned(0.5, 0.1, about(Vector3d::UnitZ(), turn) * q));
    };
    const Vector3d now = q * axis;
    if (now.head<2>().norm() < 0.02 || to.head<2>().norm() < 0.02) continue;
    const double best = error_after(task.goal(State{}, 0)->turn_about_z(scene.body(0)));
    for (double turn = -3.1; turn < 3.14; turn += 0.1) CHECK(best <= error_after(turn) + 1e-9);
  }
}

TEST_CASE("pose: an axis points up, as it is turned by a yaw, or as it is drawn") {
  const Parameters upright{{"axis", {}, "z"}, {"angle_tolerance_rad", {0.1}, ""}};
  const Pose up = pose(kPlaced, upright);
  CHECK(up.goals[0].axis->to == Vector3d::UnitZ());
  CHECK(up.goal(State{}, 0)
            ->turn_about_z(with(turned(0.5, 0.1, about(Vector3d::UnitX(), 1.0))).body(0)) == 0.0);
  const Pose yaw = pose(
      kPlaced,
      {{"axis", {}, "x"}, {"yaws_rad", {0.0, M_PI / 2}, ""}, {"angle_tolerance_rad", {0.1}, ""}});
  CHECK((yaw.goals[1].axis->to - Vector3d::UnitY()).norm() < 1e-12);
  CHECK_FALSE(yaw.goals[1].yaw);
  const Pose drawn = pose(kDrawn, {{"axis", {}, "x"}}), plain = pose(kDrawn);
  const double at = *plain.goals[5].yaw;
  CHECK((drawn.goals[5].axis->to - Vector3d(std::cos(at), std::sin(at), 0.0)).norm() < 1e-12);
  CHECK(drawn.goals[5].at == plain.goals[5].at);
}

TEST_CASE("pose: a thousand goals cost no heap on the way") {
  const Task task = load(request(kDrawn, {{"random_goals", {1000}, ""}})).seeded(2);
  const Pose& drawn = *task.as<Pose>();
  State state;
  scene::Scene scene = with({0.0, 0.0});
  const support::AllocationCounter counter;
  for (std::size_t i = 0; i < 1000; ++i) {
    scene.body(0).p_WB.head<2>() = drawn.goals[i].at;
    scene.body(0).q_WB = about(Vector3d::UnitZ(), *drawn.goals[i].yaw);
    task.advance(2.0 * static_cast<double>(i), scene, state);
    task.advance(2.0 * static_cast<double>(i) + 1.0, scene, state);
    (void)task.goal(state, 0);
    (void)task.target(scene, 0, 0.0, 0.1, state);
  }
  const std::int64_t calls = counter.count();
  CHECK(calls == 0);
  CHECK(state.goal == 1000);
  CHECK(task.done(state));
}
