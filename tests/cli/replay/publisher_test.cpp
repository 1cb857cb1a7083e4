#include "cli/replay/publisher.hpp"

#include <vector>

#include <catch2/catch.hpp>

#include "cli/recording/in_order.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "tests/idl/samples.hpp"

using namespace c3rt;
using namespace c3rt::cli;
using namespace c3rt::cli::replay;

namespace {

constexpr std::int64_t kMs = 1'000'000;

wire::BusSettings within(const std::shared_ptr<wire::Exchange>& exchange) {
  wire::BusSettings settings;
  settings.clock = wire::ClockMode::kLockstep;
  settings.session_id = 5;
  settings.exchange = exchange;
  return settings;
}

/// A second long ago: states, plans and commands every 2 ms, numbered from 1000.
void give(Listener& to) {
  for (int i = 0; i < 10; ++i) {
    const std::uint64_t seq = 1000 + i;
    const std::int64_t time_ns = 50 * kMs + 2 * i * kMs;
    auto command = wire::test::plain<wire::RobotCommand>();
    command.header = {3, seq, time_ns};
    auto plan = wire::test::plain<wire::Plan>();
    plan.header = {3, seq, time_ns};
    plan.origin.state_ns = time_ns - 8 * kMs;
    plan.valid_until_ns = time_ns + 40 * kMs;
    plan.knots[0].time_ns = time_ns + 4 * kMs;
    wire::PlannerDebug debug{};
    debug.header = plan.header;
    debug.plan_seq = seq;
    auto state = wire::test::plain<wire::RobotState>();
    state.header = {3, seq, time_ns};
    state.command_seq = i == 0 ? 0 : seq - 1;
    to.hear(state);
    to.hear(command);
    to.hear(plan);
    to.hear(debug);
  }
}

template <typename T>
std::vector<T> all(wire::Reader<T>& reader) {
  std::vector<T> samples;
  T sample{};
  while (reader.take(sample)) samples.push_back(sample);
  return samples;
}

struct Played {
  explicit Played(double rate, const std::set<std::string>& topics = {
                                   "plan", "planner/debug", "robot/state", "robot/command"}) {
    Publisher publisher(bus, topics, rate, 50 * kMs, 68 * kMs);
    begun_ns = rt::now_ns();
    publisher.begin();
    InOrder in_order(publisher, 50 * kMs);
    give(in_order);
    in_order.finish();
    written = publisher.written();
    ended_ns = rt::now_ns();
  }
  std::shared_ptr<wire::Exchange> exchange = wire::make_exchange();
  wire::Bus bus{within(exchange)}, ears{within(exchange)};
  wire::Reader<wire::Plan> plans{ears};
  wire::Reader<wire::PlannerDebug> debugs{ears};
  wire::Reader<wire::RobotState> states{ears};
  wire::Reader<wire::RobotCommand> commands{ears};
  std::map<std::string, std::uint64_t> written;
  std::int64_t begun_ns = 0, ended_ns = 0;
};

}  // namespace

TEST_CASE("a replayed sample has the present's time and session, and its stamps their distance") {
  Played played(0.0);  // as fast as it goes
  const auto plans = all(played.plans);
  REQUIRE(plans.size() == 10);
  for (const wire::Plan& plan : plans) {
    CHECK(plan.header.session_id == 5);
    CHECK(plan.header.time_ns >= played.begun_ns);
    CHECK(plan.header.time_ns <= played.ended_ns);
    CHECK(plan.origin.state_ns == plan.header.time_ns - 8 * kMs);
    CHECK(plan.valid_until_ns == plan.header.time_ns + 40 * kMs);
    CHECK(plan.knots[0].time_ns == plan.header.time_ns + 4 * kMs);
    CHECK(plan.origin.estimate_ns == 0);  // none stays none
    CHECK(plan.knots[1].time_ns == 0);
  }
}

TEST_CASE("at twice the rate samples are half as far apart, and so are their stamps") {
  Played played(2.0);
  const auto plans = all(played.plans);
  REQUIRE(plans.size() == 10);
  for (std::size_t i = 1; i < plans.size(); ++i) {
    CHECK(plans[i].header.time_ns - plans[i - 1].header.time_ns == kMs);
    CHECK(plans[i].header.time_ns - plans[i].origin.state_ns == 4 * kMs);
  }
  // nothing is written before its time
  CHECK(played.ended_ns >= plans.back().header.time_ns - kMs);
}

TEST_CASE("numbers count from 1, and those that name other samples follow them") {
  Played played(0.0);
  const auto debugs = all(played.debugs);
  const auto states = all(played.states);
  REQUIRE(debugs.size() == 10);
  REQUIRE(states.size() == 10);
  for (std::uint64_t i = 0; i < 10; ++i) {
    CHECK(debugs[i].header.seq == i + 1);
    CHECK(debugs[i].plan_seq == i + 1);
    CHECK(states[i].command_seq == i);  // the one before
  }
}

TEST_CASE("what is not wanted is not written, and then its numbers stay") {
  Played played(0.0, {"planner/debug"});
  CHECK(all(played.plans).empty());
  CHECK(all(played.states).empty());
  CHECK(played.written == std::map<std::string, std::uint64_t>{{"planner/debug", 10}});
  CHECK(all(played.debugs).front().plan_seq == 1000);
}
