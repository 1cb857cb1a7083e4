#include "controller/planner/strategy/reach.hpp"

#include <catch2/catch.hpp>

#include "config/scenario.hpp"
#include "controller/planner/strategy/candidate.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kEffector = 0.01;

Parameters parameters() {
  Parameters p =
      config::load_scenario(C3RT_SOURCE_DIRECTORY "/config/scenarios/push_box.yaml", {}).planner;
  p.approach.reach_min << 0.3, -0.3;
  p.approach.reach_max << 0.8, 0.3;
  p.sampling.reach_min << 0.3, -0.3;
  p.sampling.reach_max << 0.8, 0.3;
  p.sampling.reach_radius = 0.77;
  p.sampling.clearance = 0.01;
  return p;
}

scene::Body box() {
  scene::Body body;
  body.shape = scene::Shape::box({0.05, 0.05, 0.03});
  body.p_WB.x() = 0.5;
  return body;
}

}  // namespace

TEST_CASE("reach: a body is beyond it where the end effector has no room behind it") {
  const BodyReach reach(parameters().sampling, box(), kEffector);
  CHECK(reach.beyond({0.5, 0.0}) <= 0.0);
  // its half size, the end effector and the clearance lie between its middle and the place
  const double room = 0.05 + kEffector + 0.01;
  CHECK(reach.beyond({0.77 - room + 0.02, 0.0}) == Approx(0.02).margin(1e-6));
  CHECK(reach.beyond({0.5, 0.3 - room + 0.03}) == Approx(0.03).margin(1e-6));
  CHECK(reach.beyond({0.3 + room - 0.04, 0.0}) == Approx(0.04).margin(1e-6));
}

TEST_CASE("candidate: a push that turns a body and carries it out of reach counts nothing") {
  const Parameters p = parameters();
  Candidate candidate(p, p.sampling.servo);
  const c3::Costs costs = costs_of(candidate.c3().problem(), p.sampling.weights);
  // turned by pushing a corner away from the robot, or towards it
  const auto known = [&](double x, double side, double wanted_x) {
    scene::Scene from = candidate.c3().model().layout().world;
    from.body(0).p_WB << x, 0.0, from.table_height + from.body(0).shape.half_sizes.z();
    from.effector.p_WE = from.body(0).p_WB + Vector3d(0.075 * side, 0.04, 0.0);
    scene::Scene wanted = from;
    wanted.body(0).p_WB.x() = wanted_x;
    wanted.body(0).q_WB = Eigen::AngleAxisd(0.7 * side, Vector3d::UnitZ());
    const std::vector<scene::Scene> desired(static_cast<std::size_t>(p.N) + 1, wanted);
    return candidate.worth(costs, from, desired).known;
  };
  CHECK(known(0.5, -1.0, 0.5));
  CHECK_FALSE(known(0.69, -1.0, 0.69));
  CHECK(known(0.69, 1.0, 0.69));
  CHECK(known(0.69, -1.0, 0.75));  // it is asked for
}
