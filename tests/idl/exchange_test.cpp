// Buses within one process, without DDS: what is written is there at once, under the rules of every
// bus.
#include "idl/exchange.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include <catch2/catch.hpp>

#include "idl/dds.hpp"

using namespace c3rt;
using namespace c3rt::wire;

namespace {

constexpr std::uint64_t kSession = 7;

BusSettings settings(const std::shared_ptr<Exchange>& exchange,
                     std::uint64_t session_id = kSession) {
  BusSettings result;
  result.clock = ClockMode::kLockstep;
  result.session_id = session_id;
  result.exchange = exchange;
  return result;
}

void write(Writer<RobotState>& writer, double q, std::int64_t time_ns) {
  RobotState sample{};
  sample.q_rad[0] = q;
  REQUIRE(writer.write(sample, time_ns));
}

TEST_CASE("exchange: every reader gets every sample once, in order, with session and sequence") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange)), recorder(settings(exchange));
  Writer<RobotState> states(plant);
  Reader<RobotState> one(planner), other(recorder);
  CHECK(states.matched_readers() == 2);
  CHECK(one.matched_writers() == 1);
  for (int i = 1; i <= 60; ++i) write(states, 0.001 * i, i);
  RobotState sample{};
  for (Reader<RobotState>* reader : {&one, &other}) {
    for (int i = 1; i <= 60; ++i) {
      REQUIRE(reader->take(sample));
      CHECK(sample.header.session_id == kSession);
      CHECK(sample.header.seq == static_cast<std::uint64_t>(i));
      CHECK(sample.header.time_ns == i);
      CHECK(sample.q_rad[0] == 0.001 * i);
    }
    CHECK_FALSE(reader->take(sample));
    CHECK(reader->counters().lost == 0);
  }
}

TEST_CASE("exchange: of a reader that takes nothing the newest are kept, and the others are lost") {
  Exchange exchange;
  Inbox inbox(topic<RobotState>());
  exchange.add_reader(inbox);
  RobotState sample{};
  constexpr std::uint64_t kWritten = 100'000;
  for (std::uint64_t seq = 1; seq <= kWritten; ++seq) {
    sample.header.seq = seq;
    exchange.put(topic<RobotState>(), &sample, {1, 1}, seq);
  }
  Sender sender{};
  std::uint64_t taken = 0, first = 0;
  while (exchange.take(inbox, &sample, sender)) {
    if (++taken == 1) first = sample.header.seq;
    REQUIRE(sample.header.seq == first + taken - 1);
  }
  CHECK(sample.header.seq == kWritten);
  CHECK(taken == Inbox::kMostWaiting);
  exchange.remove_reader(inbox);
}

TEST_CASE("exchange: a reader gets what is written while it is there, and nobody else's") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange)), stranger(settings(make_exchange()));
  Writer<RobotState> states(plant);
  Reader<RobotState> elsewhere(stranger);
  write(states, 0.1, 1);
  Reader<RobotState> late(planner);
  RobotState sample{};
  CHECK_FALSE(late.take(sample));
  write(states, 0.2, 2);
  REQUIRE(late.take(sample));
  CHECK(sample.q_rad[0] == 0.2);
  CHECK_FALSE(elsewhere.take(sample));
  {
    const Reader<RobotState> gone(planner);
    CHECK(states.matched_readers() == 2);
  }
  CHECK(states.matched_readers() == 1);
}

TEST_CASE("exchange: a sample that is not finite is refused, counted and told of") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange));
  Writer<RobotState> states(plant);
  Reader<RobotState> reader(planner);
  write(states, 0.1, 1);
  write(states, std::nan(""), 2);
  RobotState sample{};
  CHECK(reader.take(sample));
  CHECK_FALSE(reader.take(sample));
  const auto refusals = planner.refusals();
  REQUIRE(refusals.size() == 1);
  CHECK(refusals[0].topic == "robot/state");
  CHECK(refusals[0].count == 1);
  CHECK(refusals[0].from == "this process");
}

TEST_CASE("exchange: of a topic with one writer the first process is obeyed, a second is not") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), second(settings(exchange)), planner(settings(exchange));
  Writer<RobotState> states(plant), others(second);
  Reader<RobotState> reader(planner);
  write(states, 0.1, 1);
  write(others, 0.2, 1);
  RobotState sample{};
  REQUIRE(reader.take_newest(sample));
  CHECK(sample.q_rad[0] == 0.1);
  CHECK(reader.counters().refused_for(Reason::kSecondWriter) == 1);
}

TEST_CASE("exchange: a process that is started anew on its bus is heard from its first sample on") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange));
  Reader<RobotState> reader(planner);
  auto states = std::make_optional<Writer<RobotState>>(plant);
  for (int i = 1; i <= 5; ++i) write(*states, 0.1, i);
  states.reset();
  CHECK(reader.matched_writers() == 0);
  states.emplace(plant);
  write(*states, 0.2, 6);
  RobotState sample{};
  REQUIRE(reader.take_newest(sample));
  CHECK(sample.header.seq == 6);
  CHECK(sample.q_rad[0] == 0.2);
}

TEST_CASE("exchange: nobody waits for what was written before its reader was there") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange));
  planner.hold_until_promised();
  Writer<RobotState> states(plant);
  for (int i = 1; i <= 5; ++i) write(states, 0.1, i);
  Reader<RobotState> late(planner);
  Sequences newest{};
  std::string missing;
  plant.newest_written(newest);
  CHECK(planner.wait_for(newest, 0, missing));
  write(states, 0.2, 6);
  plant.newest_written(newest);
  CHECK(planner.wait_for(newest, 0, missing));
  RobotState sample{};
  REQUIRE(late.take(sample));
  CHECK(sample.header.seq == 6);
}

TEST_CASE("exchange: a filter changes a sample on its way, or holds it back as if never written") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange));
  Writer<RobotState> states(plant);
  Reader<RobotState> reader(planner);
  exchange->set_filter<RobotState>([](RobotState& state) {
    state.q_rad[1] = 0.5;
    return state.q_rad[0] < 0.3;
  });
  for (int i = 1; i <= 5; ++i) write(states, 0.1 * i, i);
  exchange->set_filter<RobotState>({});
  write(states, 0.9, 6);
  RobotState sample{};
  for (const double expected : {0.1, 0.2}) {
    REQUIRE(reader.take(sample));
    CHECK(sample.q_rad[0] == expected);
    CHECK(sample.q_rad[1] == 0.5);
  }
  REQUIRE(reader.take(sample));
  CHECK(sample.q_rad[0] == 0.9);
  CHECK(sample.q_rad[1] == 0.0);
  CHECK(sample.header.seq == 3);
  CHECK(reader.counters().lost == 0);
}

TEST_CASE("exchange: what is held back is given out when it is promised, and no further") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange));
  planner.hold_until_promised();
  Writer<RobotState> states(plant);
  Reader<RobotState> reader(planner);
  write(states, 0.1, 1);
  Sequences newest{};
  plant.newest_written(newest);
  write(states, 0.2, 2);
  RobotState sample{};
  CHECK_FALSE(reader.take(sample));
  std::string missing;
  REQUIRE(planner.wait_for(newest, 0, missing));
  REQUIRE(reader.take(sample));
  CHECK(sample.q_rad[0] == 0.1);
  CHECK_FALSE(reader.take(sample));
  // within one process nothing is on its way: what is not there is missing at once
  newest[topic<RobotState>().stream] = 3;
  CHECK_FALSE(planner.wait_for(newest, 1'000'000'000'000, missing));
  CHECK(missing == "robot/state");
}

TEST_CASE(
    "exchange: a bad line spoils, loses and delays samples for one bus, and for nobody else") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange)), recorder(settings(exchange));
  Writer<RobotState> states(plant);
  Reader<RobotState> behind(planner), elsewhere(recorder);
  exchange->set_line<RobotState>(planner.identity(), [](RobotState& state) {
    state.q_rad[1] = 0.5;
    if (state.header.seq == 2) return Passage{0, 0};
    return Passage{1, state.header.seq == 3 ? 100 : 0};
  });
  exchange->arrive(1000);
  for (int i = 1; i <= 3; ++i) write(states, 0.1 * i, i);
  RobotState sample{};
  REQUIRE(behind.take(sample));
  CHECK(sample.header.seq == 1);
  CHECK(sample.q_rad[1] == 0.5);
  CHECK_FALSE(behind.take(sample));
  exchange->arrive(1099);
  CHECK_FALSE(behind.take(sample));
  exchange->arrive(1100);
  REQUIRE(behind.take(sample));
  CHECK(sample.header.seq == 3);
  CHECK(behind.counters().lost == 1);
  for (std::uint64_t seq = 1; seq <= 3; ++seq) {
    REQUIRE(elsewhere.take(sample));
    CHECK(sample.header.seq == seq);
    CHECK(sample.q_rad[1] == 0.0);
  }
  exchange->set_line<RobotState>(planner.identity(), {});
  write(states, 0.4, 4);
  REQUIRE(behind.take(sample));
  CHECK(sample.q_rad[1] == 0.0);
}

TEST_CASE("exchange: what a bad line lost is not waited for") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange));
  planner.hold_until_promised();
  Writer<RobotState> states(plant);
  Reader<RobotState> reader(planner);
  exchange->set_line<RobotState>(planner.identity(), [](RobotState&) { return Passage{0, 0}; });
  write(states, 0.1, 1);
  Sequences newest{};
  std::string missing;
  plant.newest_written(newest);
  CHECK(planner.wait_for(newest, 0, missing));
  RobotState sample{};
  CHECK_FALSE(reader.take(sample));
}

TEST_CASE("exchange: a sample that comes twice, or after a later one, is let in once") {
  const auto exchange = make_exchange();
  Bus plant(settings(exchange)), planner(settings(exchange));
  Writer<RobotState> states(plant);
  Reader<RobotState> reader(planner);
  exchange->set_line<RobotState>(planner.identity(), [](RobotState& state) {
    return Passage{2, state.header.seq == 2 ? 50 : 0};
  });
  for (int i = 1; i <= 3; ++i) write(states, 0.1 * i, i);
  RobotState sample{};
  for (const std::uint64_t seq : {1, 3}) {
    REQUIRE(reader.take(sample));
    CHECK(sample.header.seq == seq);
  }
  CHECK_FALSE(reader.take(sample));
  exchange->arrive(50);
  CHECK_FALSE(reader.take(sample));
  CHECK(reader.counters().refused_for(Reason::kOldSequence) == 4);
  CHECK(reader.counters().received == 2);
}

TEST_CASE("exchange: a clock of the machine is refused") {
  BusSettings realtime = settings(make_exchange());
  realtime.clock = ClockMode::kRealtime;
  CHECK_THROWS_AS(Bus(realtime), WireError);
}

}  // namespace
