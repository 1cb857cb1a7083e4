// Vision on the types of the wire, without a bus, a clock and a plant's scene.
#include "vision/node.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <catch2/catch.hpp>

#include "vision/service.hpp"

using namespace c3rt;
using namespace c3rt::vision;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriod = 10 * kMs;
constexpr double kRadius = 0.03;

constexpr double kTouch = kRadius + 0.02;  // of centres

Parameters parameters() {
  Parameters parameters{};
  parameters.acceleration_filter = {1e-4, 5.0, 0.3, 0.003, 0.05};
  parameters.rate = 100.0;
  parameters.estimator = {1.0, 1.0, VelocityFilter::kTwoTap, 0.05, 0.05, 2};
  return parameters;
}

/// A camera of its own: it triggers by itself, and no sim/scene reaches it.
class SelfTriggered : public Source {
 public:
  std::optional<std::int64_t> exposed() override {
    return std::exchange(waiting_, std::optional<std::int64_t>());
  }
  std::vector<Observation> observe(const std::vector<Prediction>& predictions) override {
    predicted = predictions;
    std::vector<Observation> seen(predictions.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      seen[i].measurement = {
          exposure_ns_, found, {p_WB.x(), p_WB.y() + static_cast<double>(i), p_WB.z()}};
      seen[i].cameras_used = found ? 2 : 0;
      seen[i].views.resize(2);
      for (View& view : seen[i].views) view.frame = view.detection.found = view.used = found;
    }
    return seen;
  }
  void freeze(int camera, std::int64_t until_ns) override {
    frozen = camera;
    frozen_until_ns = until_ns;
  }
  void trigger(std::int64_t exposure_ns) {
    exposure_ns_ = exposure_ns;
    waiting_ = exposure_ns;
  }

  bool found = true;
  Eigen::Vector3d p_WB{0.5, 0.1, kRadius};
  std::vector<Prediction> predicted;
  int frozen = -2;
  std::int64_t frozen_until_ns = -1;

 private:
  std::int64_t exposure_ns_ = 0;
  std::optional<std::int64_t> waiting_;
};

struct World {
  explicit World(int objects = 1) : node(parameters(), starts(objects), source) {}
  static std::vector<ObjectStart> starts(int objects) {
    std::vector<ObjectStart> result;
    for (int i = 0; i < objects; ++i)
      result.push_back({"object" + std::to_string(i), kRadius, {0.4, 0.2 + i, kRadius}, kTouch});
    return result;
  }
  /// The next exposure.
  const Node::Output& step() {
    now_ns += kPeriod;
    source.trigger(now_ns);
    return node.step(now_ns);
  }
  void inject(c3rt_v2_FaultKind kind, double duration, int index = 0) {
    wire::FaultInject fault{};
    fault.process = c3rt_v2_PROCESS_VISION;
    fault.kind = kind;
    fault.duration_s = duration;
    fault.index = index;
    node.inject(fault, now_ns);
  }
  SelfTriggered source;
  Node node;
  std::int64_t now_ns = 0;
};

TEST_CASE("vision node: a source that triggers by itself needs no scene of a simulated plant") {
  World world(2);
  CHECK(world.node.step(kMs).exposure_ns == 0);
  CHECK(world.node.step(kMs).estimates.empty());
  const Node::Output& out = world.step();
  CHECK(out.exposure_ns == kPeriod);
  REQUIRE(out.estimates.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const wire::ObjectEstimate& estimate = out.estimates[i];
    CHECK(estimate.object_index == static_cast<int>(i));
    CHECK(std::string(estimate.name) == "object" + std::to_string(i));
    CHECK(estimate.exposure_ns == kPeriod);
    CHECK(estimate.valid);
    CHECK(estimate.sensors_used == 2);
    CHECK(estimate.p_WB_m[0] == 0.5);
    CHECK(estimate.p_WB_m[1] == 0.1 + static_cast<double>(i));
  }
  REQUIRE(out.detections.size() == 4);
  CHECK(out.detections[3].camera == 1);
  CHECK(out.detections[3].object_index == 1);
  CHECK(out.detections[3].exposure_ns == kPeriod);
  // each exposure once
  CHECK(world.node.step(world.now_ns + kMs).exposure_ns == 0);
  CHECK(world.node.counters().exposures == 1);
}

TEST_CASE("vision node: it expects an object where the scenario puts it, then where it rolls to") {
  World world;
  world.step();
  REQUIRE(world.source.predicted.size() == 1);
  CHECK(world.source.predicted[0].p_WB == Eigen::Vector3d(0.4, 0.2, kRadius));
  for (int i = 0; i < 10; ++i) {
    world.source.p_WB.x() += 0.001;  // 0.1 m/s
    world.step();
  }
  CHECK(world.source.predicted[0].p_WB.x() ==
        Approx(world.source.p_WB.x()).margin(1e-9));  // of the newest exposure
}

/// The object rolls freely from here on, down a slope.
Eigen::Vector2d after_rolling(World& world, double slope, double seconds, bool effector_known) {
  const Eigen::Vector3d start = world.source.p_WB;
  Eigen::Vector2d learnt = Eigen::Vector2d::Zero();
  for (double t = 0.01; t < seconds; t += 0.01) {
    world.source.p_WB.x() = start.x() + 0.5 * slope * t * t;
    if (effector_known) world.node.see_effector(world.now_ns, {0.0, 0.0, 1.0});
    const wire::ObjectEstimate& estimate = world.step().estimates[0];
    learnt << estimate.a_WB_m_per_s2[0], estimate.a_WB_m_per_s2[1];
  }
  return learnt;
}

/// The end effector touches the object where it lies, and leaves it.
void touch(World& world) {
  for (int i = 0; i < 10; ++i) {
    world.node.see_effector(world.now_ns, world.source.p_WB + kTouch * Eigen::Vector3d::UnitZ());
    world.step();
  }
}

TEST_CASE("vision node: what accelerates an object is learnt once the end effector has left it") {
  World world;
  touch(world);
  const Eigen::Vector2d learnt = after_rolling(world, 0.1, 1.0, true);
  CHECK((learnt - Eigen::Vector2d(0.1, 0.0)).norm() < 0.01);
}

TEST_CASE("vision node: of an object that a hand may hold or move no acceleration is learnt") {
  SECTION("the end effector has not been there yet") {
    World world;
    CHECK(after_rolling(world, 0.1, 1.0, true).isZero(0.0));
  }
  SECTION("where the end effector is, is not known") {
    World world;
    touch(world);
    const Eigen::Vector2d learnt = after_rolling(world, 0.1, 0.1, false);
    CHECK((after_rolling(world, 0.2, 1.0, false) - learnt).isZero(0.0));
  }
  SECTION("it left long ago") {
    World world;
    touch(world);
    const Eigen::Vector2d learnt = after_rolling(world, 0.0, 2.5, true);
    CHECK(after_rolling(world, 0.1, 1.0, true) == learnt);
  }
  SECTION("it was lost in the meantime") {
    World world;
    touch(world);
    world.inject(c3rt_v2_FAULT_LOSE_OBJECT, 0.2);
    after_rolling(world, 0.0, 0.25, true);
    CHECK(after_rolling(world, 0.1, 1.0, true).isZero(1e-3));
  }
}

TEST_CASE("vision node: an object out of view is lost after a while, told once, and found again") {
  World world;
  const Node::Output& out = world.step();
  CHECK(out.events == std::vector<std::string>{"object=0 found"});
  CHECK_FALSE(world.node.degraded());
  world.source.found = false;
  int told = 0;
  for (int i = 0; i < 20; ++i) told += static_cast<int>(world.step().events.size());
  CHECK(told == 1);
  CHECK_FALSE(out.estimates[0].valid);
  CHECK(out.estimates[0].p_WB_m[0] == 0.5);  // the last good number
  CHECK(world.node.degraded());
  CHECK(world.node.text() == "lost object 0");
  CHECK(world.node.counters().lost_events == 1);
  world.source.found = true;
  world.step();
  CHECK(out.events == std::vector<std::string>{"object=0 found"});
  CHECK(world.node.text() == "tracks the object");
}

TEST_CASE("vision node: exposures that did not come are counted") {
  World world;
  world.step();
  world.now_ns += 3 * kPeriod;
  world.step();
  CHECK(world.node.counters().dropped_frames == 3);
}

TEST_CASE("vision node: what is exposed during a stall is never looked at") {
  World world;
  world.step();
  world.inject(c3rt_v2_FAULT_STALL, 0.035);
  for (int i = 0; i < 3; ++i) CHECK(world.step().exposure_ns == 0);
  CHECK(world.node.step(world.now_ns + 6 * kMs).exposure_ns == 0);  // it is over
  CHECK(world.step().exposure_ns == world.now_ns);
}

TEST_CASE("vision node: a NaN, a lost object and a frozen camera last as long as was asked") {
  World world;
  world.step();
  world.inject(c3rt_v2_FAULT_NAN, 0.025);
  CHECK(std::isnan(world.step().estimates[0].p_WB_m[0]));
  CHECK(std::isnan(world.step().estimates[0].p_WB_m[0]));
  CHECK(world.step().estimates[0].p_WB_m[0] == 0.5);

  world.inject(c3rt_v2_FAULT_LOSE_OBJECT, 1000.0);
  const Node::Output& out = world.step();
  CHECK(out.estimates[0].sensors_used == 0);
  CHECK_FALSE(out.detections[0].found);
  CHECK_FALSE(out.detections[0].used);
  for (int i = 0; i < 10; ++i) world.step();
  CHECK_FALSE(out.estimates[0].valid);

  world.inject(c3rt_v2_FAULT_FREEZE_CAMERA, 2.0, 1);
  CHECK(world.source.frozen == 1);
  CHECK(world.source.frozen_until_ns == world.now_ns + 2'000 * kMs);
  world.inject(c3rt_v2_FAULT_NONE, 0.0);
  CHECK(world.source.frozen == -1);
  CHECK(world.step().estimates[0].valid);
}

TEST_CASE("vision service: a camera of its own gives estimates on a bus that has no sim/scene") {
  wire::BusSettings settings;
  settings.clock = wire::ClockMode::kLockstep;
  settings.session_id = 7;
  settings.exchange = wire::make_exchange();
  wire::Bus bus(settings), other(settings);
  wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_VISION, {}, {});
  auto camera = std::make_unique<SelfTriggered>();
  SelfTriggered& source = *camera;
  Service service(bus, endpoint, parameters(), World::starts(2), 0.005, std::move(camera));
  wire::Reader<wire::ObjectEstimate> estimates(other);
  wire::Reader<wire::ObjectDetection> detections(other);
  wire::ObjectEstimate estimate{};
  service.step(kMs);
  CHECK_FALSE(estimates.take(estimate));
  source.trigger(kPeriod);
  service.step(kPeriod);
  for (int i = 0; i < 2; ++i) {
    REQUIRE(estimates.take(estimate));
    CHECK(estimate.object_index == i);
    CHECK(estimate.valid);
    CHECK(estimate.exposure_ns == kPeriod);
    CHECK(estimate.header.time_ns == kPeriod + 5 * kMs);
  }
  CHECK_FALSE(estimates.take(estimate));
  wire::ObjectDetection detection{};
  int count = 0;
  while (detections.take(detection)) ++count;
  CHECK(count == 4);
}

}  // namespace
