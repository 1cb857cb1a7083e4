#include "cli/recorder.hpp"

#include <algorithm>

#include <catch2/catch.hpp>

#include "controller/rt/periodic_clock.hpp"
#include "controller/task/circle.hpp"
#include "tests/cli/eventually.hpp"
#include "tests/idl/samples.hpp"
#include "tests/support/own_domain.hpp"

using namespace c3rt;
using namespace c3rt::cli;

namespace {

using wire::test::plain;

wire::BusSettings settings(std::uint64_t session) {
  wire::BusSettings bus;
  bus.domain = support::kOwnDomain;
  bus.profile_uri = C3RT_SOURCE_DIRECTORY "/config/dds/loopback.xml";
  bus.session_id = session;
  return bus;
}

TEST_CASE("Recorder: samples that cannot be are refused, not followed, and told") {
  Goal goal{task::Circle{{0.55, 0.0}, 0.1, 0.0}, 3, 60.0};
  Recorder recorder(settings(7), goal);
  // a process of the run gone wrong: of the right session, and nobody else writes
  wire::Bus bus(settings(7));
  wire::Writer<wire::Plan> plans(bus);
  wire::Writer<wire::Scene> scenes(bus);
  auto plan = plain<wire::Plan>();
  plan.knot_count = 1000000;
  plan.valid_until_ns = rt::now_ns() + 1'000'000'000;
  plan.knots[0].time_ns = rt::now_ns();
  auto scene = plain<wire::Scene>();
  scene.object_count = -1;
  const auto refused = [&](const char* topic) {
    const std::vector<wire::RefusedCount> all = recorder.live().refused;
    return std::any_of(all.begin(), all.end(), [&](const wire::RefusedCount& count) {
      return count.topic == topic && count.reason == wire::Reason::kValue;
    });
  };
  CHECK(eventually([&] {
    plans.write(plan, rt::now_ns());
    scenes.write(scene, rt::now_ns());
    return refused("plan") && refused("sim/scene");
  }));
  recorder.stop();
  CHECK(recorder.failure().empty());
  CHECK(recorder.series().plan.empty());
  CHECK(recorder.series().scene.empty());
}

}  // namespace
