#include "cli/chaos/recovery.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include <catch2/catch.hpp>

#include "cli/chaos/report.hpp"
#include "controller/base/time.hpp"

using namespace c3rt;
using namespace c3rt::cli::chaos;

namespace {

constexpr std::int64_t kMs = 1'000'000;

Fault fault_of(std::string_view kind, const char* target) {
  Fault fault;
  fault.kind = &*std::find_if(kinds().begin(), kinds().end(),
                              [kind](const Kind& known) { return known.name == kind; });
  fault.target = target;
  return fault;
}

/// A run whose samples are made by hand, one cycle after the other.
struct Stream {
  Recovery recovery;
  std::int64_t now_ns = 1000 * kMs;
  std::uint64_t seq = 0;
  double x = 0.0, object = 0.0;

  /// @param seen_ns stamps of what the command is made from
  void cycle(std::int64_t seen_ns, double speed, bool moves = true) {
    now_ns += kMs;
    ++seq;
    x += 1e-3 * speed;
    wire::Plan plan{};
    std::strcpy(plan.phase, "roll");
    plan.origin.exposure_ns = seen_ns;
    recovery.hear(plan);
    wire::Scene scene{};
    scene.object_count = 1;
    scene.header.time_ns = now_ns;
    scene.objects[0].p_WB_m[0] = object;
    recovery.hear(scene);
    wire::RobotCommand command{};
    command.header = {1, seq, now_ns};
    command.mode = c3rt_v2_IMPEDANCE_TRACK;
    command.origin = {seen_ns, seen_ns, seen_ns, seen_ns};
    recovery.hear(command);
    wire::RobotState state{};
    state.header = {1, seq, now_ns};
    state.mode = moves ? c3rt_v2_ROBOT_MOVE : c3rt_v2_ROBOT_REFLEX;
    state.command_seq = seq;
    state.p_WE_m[0] = x;
    recovery.hear(state);
  }
  void run(int cycles, std::int64_t seen_ns, double speed, bool moves = true) {
    for (int i = 0; i < cycles; ++i) cycle(seen_ns, speed, moves);
  }
  const Outcome& newest() const { return recovery.outcomes().back(); }
};

}  // namespace

TEST_CASE("chaos: it goes on when the arm follows what was seen after the fault, and has moved") {
  Stream stream;
  stream.recovery.begin(fault_of("stop", "planner"), stream.now_ns);
  stream.run(100, stream.now_ns, 0.1);
  stream.recovery.end(stream.now_ns);
  const std::int64_t end_ns = stream.now_ns;
  // the last plan from before is still followed, and moves the arm far enough
  stream.run(300, end_ns - kMs, 0.1);
  CHECK_FALSE(std::isfinite(stream.newest().resumed));
  // a robot that has stopped goes nowhere by itself
  stream.run(200, end_ns + kMs, 0.1, false);
  CHECK_FALSE(std::isfinite(stream.newest().resumed));
  // 2 mm at 0.1 m/s take 20 ms and one to begin with
  stream.run(50, end_ns + kMs, 0.1);
  CHECK(stream.newest().resumed == Approx(0.521).margin(2e-3));
  CHECK_FALSE(std::isfinite(stream.newest().at_task));
  stream.object = 0.003;
  stream.cycle(end_ns + kMs, 0.1);
  CHECK(stream.newest().at_task == Approx(0.551).margin(2e-3));
}

TEST_CASE("chaos: an arm that does not move has not gone on, and patience ends once") {
  Stream stream;
  stream.recovery.begin(fault_of("kill", "plant"), stream.now_ns);
  stream.recovery.end(stream.now_ns);
  const std::int64_t end_ns = stream.now_ns;
  stream.run(1000, end_ns + kMs, 0.0);
  CHECK_FALSE(std::isfinite(stream.newest().resumed));
  const std::int64_t late_ns = end_ns + base::nanoseconds(Recovery::kPatience);
  CHECK_FALSE(stream.recovery.lost_patience(late_ns - kMs));
  CHECK(stream.recovery.lost_patience(late_ns + kMs));
  CHECK_FALSE(stream.recovery.lost_patience(late_ns + 2 * kMs));
  stream.recovery.finish();
  const auto times = by_kind(stream.recovery.outcomes());
  CHECK(times.at("kill plant").not_resumed == 1);
  const auto criteria = criteria_of(stream.recovery.outcomes());
  REQUIRE(criteria.size() == 1);
  CHECK(criteria[0].name == "recovery_of_plant_p99_s");
  CHECK_FALSE(criteria[0].met);
}

TEST_CASE("chaos: faults that come before it has gone on do not make it patient") {
  Stream stream;
  for (int i = 0; i < 5; ++i) {
    stream.recovery.begin(fault_of("stop", "vision"), stream.now_ns);
    stream.now_ns += 10'000 * kMs;  // which do not count
    stream.recovery.end(stream.now_ns);
    stream.now_ns += base::nanoseconds(0.22 * Recovery::kPatience);
    CAPTURE(i);
    CHECK(stream.recovery.lost_patience(stream.now_ns) == (i == 4));
  }
  stream.recovery.finish();
  const Times times = by_kind(stream.recovery.outcomes()).at("stop vision");
  CHECK(times.count == 5);
  CHECK(times.overtaken == 4);
  CHECK(times.not_resumed == 1);
}
