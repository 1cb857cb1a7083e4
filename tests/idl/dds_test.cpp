#include "idl/dds.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <catch2/catch.hpp>
#include <dds/dds.h>

#include "idl/discovery.hpp"
#include "idl/one_writer.hpp"
#include "idl/replies.hpp"
#include "tests/idl/bus_fixture.hpp"
#include "tests/idl/raw_writer.hpp"
#include "tests/idl/samples.hpp"
#include "tests/support/allocation_counter.hpp"

using namespace c3rt;
using namespace c3rt::wire;
namespace test = c3rt::wire::test;

namespace {

using test::eventually;
using test::kMs;
using test::kSecond;
using test::numbered;
using test::plain;
using test::RawWriter;

/// Takes everything that arrives within the patience of `eventually`, until `count` samples are
/// there.
template <typename T>
std::vector<T> take(Reader<T>& reader, std::size_t count) {
  std::vector<T> samples;
  T sample{};
  (void)eventually([&] {
    while (reader.take(sample)) samples.push_back(sample);
    return samples.size() >= count;
  });
  return samples;
}

TEST_CASE(
    "wire: a process that is started anew gets the last target, but no fault or request again") {
  Bus client(test::settings(ClockMode::kRealtime));
  Writer<FaultInject> faults(client);
  Writer<ServiceRequest> requests(client);
  Writer<TaskTarget> targets(client);
  FaultInject fault{};
  ServiceRequest request{};
  TaskTarget target{};
  faults.write(fault, 1 * kMs);
  requests.write(request, 1 * kMs);
  targets.write(target, 1 * kMs);
  Bus process(test::settings(ClockMode::kRealtime));
  Reader<FaultInject> of_faults(process);
  Reader<ServiceRequest> of_requests(process);
  Reader<TaskTarget> of_targets(process);
  REQUIRE(take(of_targets, 1).size() == 1);
  REQUIRE(
      eventually([&] { return faults.matched_readers() > 0 && requests.matched_readers() > 0; }));
  faults.write(fault, 2 * kMs);
  requests.write(request, 2 * kMs);
  const auto heard = take(of_faults, 1);
  REQUIRE(heard.size() == 1);
  CHECK(heard[0].header.seq == 2);
  const auto asked = take(of_requests, 1);
  REQUIRE(asked.size() == 1);
  CHECK(asked[0].header.seq == 2);
}

TEMPLATE_LIST_TEST_CASE("wire: what is written in one process is read in another, bit by bit", "",
                        TopicTypes) {
  constexpr std::uint64_t kSession = 42;
  // in lockstep every topic is reliable, so a write before the reader is there is not lost
  int written[2];
  REQUIRE(pipe(written) == 0);
  test::Child child([&] {
    Bus bus(test::settings(ClockMode::kLockstep, kSession));
    Writer<TestType> writer(bus);
    TestType sample = numbered<TestType>();
    for (int i = 1; i <= 3; ++i) {
      if (!writer.write(sample, i * kMs)) return 1;
    }
    if (write(written[1], "", 1) != 1) return 3;
    return eventually([&] { return writer.matched_readers() > 0; }) && (sleep(20), true) ? 0 : 2;
  });
  Bus bus(test::settings(ClockMode::kLockstep));
  bus.adopt_session(kSession);
  char done = 0;
  REQUIRE(read(written[0], &done, 1) == 1);
  close(written[0]);
  close(written[1]);
  Reader<TestType> reader(bus);
  const auto samples = take(reader, topic<TestType>().qos == Qos::kStatus ? 1 : 3);
  REQUIRE(samples.size() >= 1);
  TestType expected = numbered<TestType>();
  // a late reader of a status gets the last one only
  std::uint64_t seq = topic<TestType>().qos == Qos::kStatus ? 3 : 1;
  for (const TestType& sample : samples) {
    expected.header = {kSession, seq, static_cast<std::int64_t>(seq) * kMs};
    ++seq;
    CHECK(std::memcmp(&sample, &expected, sizeof sample) == 0);
  }
  CHECK(seq == 4);
  CHECK(reader.counters().lost == 0);
}

TEST_CASE("Reader: the session is the plant's; one that was started again is another writer") {
  Bus old_plant(test::settings()), new_plant(test::settings()), bus(test::settings());
  Reader<RobotState> states(bus);
  RawWriter before(old_plant, topic<RobotState>(), kProcessStrength);
  const auto state = plain<RobotState>();
  before.write(state, 300, 1);
  REQUIRE(take(states, 1).size() == 1);
  CHECK(bus.session_id() == 300);
  // the same writer has one session
  before.write(state, 400, 2);
  before.write(state, 300, 3);
  REQUIRE(take(states, 1).at(0).header.seq == 3);
  CHECK(bus.session_id() == 300);
  CHECK(states.counters().refused_for(Reason::kOtherSession) == 1);
  // the old plant is silent: the new one is believed, whatever its number
  RawWriter after(new_plant, topic<RobotState>(), kProcessStrength);
  RobotState taken{};
  std::uint64_t seq = 0;
  REQUIRE(eventually([&] {
    after.write(state, 200, ++seq);
    return states.take(taken);
  }));
  CHECK(taken.header.session_id == 200);
  CHECK(bus.session_id() == 200);
  CHECK(states.counters().refused_for(Reason::kSecondWriter) > 0);
}

TEST_CASE("Reader: nobody but the plant begins a session") {
  Bus peers(test::settings()), plant(test::settings()), bus(test::settings());
  Reader<ObjectEstimate> estimates(bus);
  Reader<Plan> plans(bus);
  Reader<TaskTarget> targets(bus);
  Reader<ServiceStatus> statuses(bus);
  RawWriter estimate_writer(peers, topic<ObjectEstimate>()), plan_writer(peers, topic<Plan>()),
      target_writer(peers, topic<TaskTarget>()), status_writer(peers, topic<ServiceStatus>());
  estimate_writer.write(plain<ObjectEstimate>(), ~0ull, 1);
  plan_writer.write(plain<Plan>(), 1'800'000'000'000'000'000, 1);
  target_writer.write(TaskTarget{}, 500, 1);
  target_writer.write(TaskTarget{}, 0, 2);
  status_writer.write(ServiceStatus{}, 700, 1);
  // before the plant is heard, everybody may be of its session: in lockstep the plan of a tick may
  // arrive before the tick itself, and must not be lost
  CHECK(take(estimates, 1).size() == 1);
  CHECK(take(plans, 1).size() == 1);
  CHECK(take(targets, 2).size() == 2);
  CHECK(take(statuses, 1).size() == 1);
  CHECK(bus.session_id() == 0);
  Reader<RobotState> states(bus);
  RawWriter state_writer(plant, topic<RobotState>(), kProcessStrength);
  state_writer.write(plain<RobotState>(), 300, 1);
  CHECK(take(states, 1).size() == 1);
  CHECK(bus.session_id() == 300);
  estimate_writer.write(plain<ObjectEstimate>(), ~0ull, 2);
  plan_writer.write(plain<Plan>(), 1'800'000'000'000'000'000, 2);
  plan_writer.write(plain<Plan>(), 0, 3);
  plan_writer.write(plain<Plan>(), 300, 4);
  target_writer.write(TaskTarget{}, 200, 3);
  target_writer.write(TaskTarget{}, 300, 4);
  CHECK(take(plans, 1).at(0).header.seq == 4);
  CHECK(take(targets, 1).at(0).header.seq == 4);
  CHECK(bus.session_id() == 300);
  CHECK(plans.counters().refused_for(Reason::kOtherSession) == 2);
  CHECK(targets.counters().refused_for(Reason::kOtherSession) == 1);
  CHECK(eventually([&] {
    ObjectEstimate estimate{};
    return !estimates.take(estimate) &&
           estimates.counters().refused_for(Reason::kOtherSession) == 1;
  }));
}

TEST_CASE("Reader: once the robot's state was heard, a stranger's scene tells of no other plant") {
  Bus stranger(test::settings()), plant(test::settings()), bus(test::settings());
  Reader<RobotState> states(bus);
  Reader<Scene> scenes(bus);
  RawWriter wrong(stranger, topic<Scene>()), right(plant, topic<Scene>(), kProcessStrength),
      state_writer(plant, topic<RobotState>(), kProcessStrength);
  wrong.write(plain<Scene>(), 999, 1);
  CHECK(take(scenes, 1).size() == 1);
  CHECK(bus.session_id() == 999);  // the only plant that there is
  state_writer.write(plain<RobotState>(), 300, 1);
  CHECK(take(states, 1).size() == 1);
  CHECK(bus.session_id() == 300);
  wrong.write(plain<Scene>(), 999, 2);
  right.write(plain<Scene>(), 300, 1);
  const auto taken = take(scenes, 1);
  REQUIRE(taken.size() == 1);
  CHECK(taken[0].header.session_id == 300);
  CHECK(bus.session_id() == 300);
}

TEST_CASE("Reader: the plant keeps its own session, whatever others claim") {
  Bus peers(test::settings()), plant(test::settings(ClockMode::kRealtime, 100));
  Reader<RobotState> states(plant);
  RawWriter writer(peers, topic<RobotState>());
  writer.write(plain<RobotState>(), 500, 1);
  writer.write(plain<RobotState>(), 100, 2);
  REQUIRE(take(states, 1).size() == 1);
  CHECK(plant.session_id() == 100);
}

TEST_CASE("Reader: a plan queued before the plant restarted is not given out after") {
  Bus peers(test::settings()), bus(test::settings());
  bus.adopt_session(100);
  Reader<Plan> plans(bus);
  RawWriter writer(peers, topic<Plan>());
  writer.write(plain<Plan>(), 100, 1);
  REQUIRE(eventually([&] {
    bus.wait_for_data(10 * kMs);  // moves it to the queue
    return plans.counters().received == 1;
  }));
  bus.adopt_session(200);
  Plan plan{};
  CHECK_FALSE(plans.take(plan));
  CHECK(plans.counters().refused_for(Reason::kOtherSession) == 1);
}

TEST_CASE("Reader: a second writer of what moves the robot is refused, counted and named") {
  int go[2];
  REQUIRE(pipe(go) == 0);
  test::Child stranger([&] {
    char word = 0;
    if (read(go[0], &word, 1) != 1) return 1;
    Bus bus(test::settings());
    RawWriter writer(bus, topic<RobotCommand>());
    auto wild = plain<RobotCommand>();
    wild.tau_nm[0] = 87.0;
    if (!eventually([&] { return writer.matched(); })) return 2;
    // of no session, and of the right one
    for (std::uint64_t i = 1; i <= 4000; ++i) {
      writer.write(wild, i % 2 == 1 ? 0 : 7, i);
      usleep(5000);
    }
    return 0;
  });
  Bus impedance(test::settings(ClockMode::kRealtime, 7)),
      plant(test::settings(ClockMode::kRealtime, 7));
  Writer<RobotCommand> commands(impedance);
  Reader<RobotCommand> reader(plant);
  REQUIRE(eventually([&] { return commands.matched_readers() == 1; }));
  auto command = plain<RobotCommand>();
  REQUIRE(commands.write(command, 1));
  REQUIRE(take(reader, 1).size() == 1);
  REQUIRE(write(go[1], "g", 1) == 1);
  bool obeyed = false;
  const bool refused = eventually([&] {
    commands.write(command, 1);
    RobotCommand taken{};
    while (reader.take(taken)) obeyed = obeyed || taken.tau_nm[0] != 0.0;
    return reader.counters().refused_for(Reason::kSecondWriter) >= 5;
  });
  CHECK(refused);
  CHECK_FALSE(obeyed);
  const auto refusals = plant.refusals();
  REQUIRE(refusals.size() == 1);
  CHECK(refusals[0].topic == "robot/command");
  CHECK(refusals[0].reason == Reason::kSecondWriter);
  CHECK(refusals[0].count >= 5);
  CHECK_THAT(refusals[0].from, Catch::Contains("(pid " + std::to_string(stranger.pid()) + ")"));
  CHECK_THAT(refusals[0].latest, Catch::StartsWith("obeyed is ") &&
                                     Catch::Contains("(pid " + std::to_string(getpid()) + ")"));
  close(go[0]);
  close(go[1]);
}

TEST_CASE("Reader: the process's own writer is obeyed before a client that plays it") {
  Bus client(test::settings()), planner(test::settings(ClockMode::kRealtime, 7)),
      bus(test::settings(ClockMode::kRealtime, 7));
  Reader<Plan> reader(bus);
  RawWriter played(client, topic<Plan>());
  played.write(plain<Plan>(), 7, 1);
  CHECK(take(reader, 1).size() == 1);  // nobody else plans
  Writer<Plan> plans(planner);
  REQUIRE(eventually([&] { return plans.matched_readers() == 1; }));
  auto plan = plain<Plan>();
  REQUIRE(plans.write(plan, 1));
  CHECK(take(reader, 1).size() == 1);
  played.write(plain<Plan>(), 7, 2);
  REQUIRE(eventually([&] {
    Plan taken{};
    CHECK_FALSE(reader.take(taken));
    return reader.counters().refused_for(Reason::kSecondWriter) == 1;
  }));
}

TEST_CASE("Reader: a client takes over from a process that has gone, not from one that is silent") {
  Bus client(test::settings()), bus(test::settings(ClockMode::kRealtime, 7));
  auto planner = std::make_unique<Bus>(test::settings(ClockMode::kRealtime, 7));
  auto plans = std::make_unique<Writer<Plan>>(*planner);
  Reader<Plan> reader(bus);
  REQUIRE(eventually([&] { return plans->matched_readers() == 1; }));
  auto plan = plain<Plan>();
  REQUIRE(plans->write(plan, 1));
  REQUIRE(take(reader, 1).size() == 1);
  RawWriter played(client, topic<Plan>());
  std::uint64_t seq = 0;
  Plan taken{};
  const std::int64_t begin_ns = rt::now_ns();
  while (rt::now_ns() - begin_ns < 3 * kSecond / 2) {  // three times what counts as silence
    played.write(plan, 7, ++seq);
    CHECK_FALSE(reader.take(taken));
    usleep(20'000);
  }
  plans.reset();
  planner.reset();
  CHECK(eventually([&] {
    played.write(plan, 7, ++seq);
    return reader.take(taken);
  }));
}

TEST_CASE("Reader: in lockstep a client's plan is not obeyed even if it comes first") {
  Bus client(test::settings(ClockMode::kLockstep)),
      planner(test::settings(ClockMode::kLockstep, 7)),
      bus(test::settings(ClockMode::kLockstep, 7));
  Reader<Plan> reader(bus);
  RawWriter stray(client, topic<Plan>());
  stray.write(plain<Plan>(), 7, 1);
  REQUIRE(eventually([&] {
    Plan taken{};
    CHECK_FALSE(reader.take(taken));
    return reader.counters().refused_for(Reason::kSecondWriter) == 1;
  }));
  Writer<Plan> plans(planner);
  auto plan = plain<Plan>();
  REQUIRE(plans.write(plan, 1));
  CHECK(take(reader, 1).size() == 1);
  // nor does a stranger pace the run
  Reader<Done> dones(bus);
  RawWriter stray_done(client, topic<Done>());
  stray_done.write(Done{}, 7, 1);
  CHECK(eventually([&] {
    Done taken{};
    CHECK_FALSE(dones.take(taken));
    return dones.counters().refused_for(Reason::kSecondWriter) == 1;
  }));
}

TEST_CASE("Reader: what cannot be is refused by value, with what was expected") {
  Bus client(test::settings()), bus(test::settings(ClockMode::kRealtime, 7));
  Reader<Plan> plans(bus);
  Reader<Scene> scenes(bus);
  Reader<ObjectEstimate> estimates(bus);
  RawWriter plan_writer(client, topic<Plan>()), scene_writer(client, topic<Scene>()),
      estimate_writer(client, topic<ObjectEstimate>());
  auto plan = plain<Plan>();
  plan.knot_count = 1000000;
  auto scene = plain<Scene>();
  scene.object_count = -1;
  auto estimate = plain<ObjectEstimate>();
  estimate.v_WB_m_per_s[1] = 1e6;
  plan_writer.write(plan, 7, 1);
  scene_writer.write(scene, 7, 1);
  estimate_writer.write(estimate, 7, 1);
  const auto refused = [&](auto& reader) {
    std::decay_t<decltype(take(reader, 1)[0])> taken{};
    CHECK_FALSE(reader.take(taken));
    return reader.counters().refused_for(Reason::kValue) == 1;
  };
  REQUIRE(eventually([&] { return refused(plans) && refused(scenes) && refused(estimates); }));
  std::map<std::string, std::string> text;
  for (const RefusedCount& count : bus.refusals()) text[count.topic] = count.latest;
  CHECK(text["plan"] == "knot_count is 1000000, expected 1 to 16");
  CHECK(text["sim/scene"] == "object_count is -1, expected 0 to 8");
  CHECK(text["object/estimate"] == "v_WB_m_per_s[1] is 1000000, expected -20 to 20");
}

TEST_CASE("Reader: a sequence number 0 and a time far ahead are refused with a word") {
  Bus client(test::settings()), bus(test::settings(ClockMode::kRealtime, 7));
  Reader<RobotState> states(bus);
  RawWriter writer(client, topic<RobotState>());
  const auto state = plain<RobotState>();
  writer.write(state, 7, 0);
  const auto latest = [&](std::uint64_t count) {
    (void)eventually([&] {
      RobotState taken{};
      CHECK_FALSE(states.take(taken));
      return states.counters().refused_for(Reason::kHeader) == count;
    });
    const auto refusals = bus.refusals();
    return refusals.empty() ? std::string() : refusals[0].latest;
  };
  CHECK_THAT(latest(1), Catch::StartsWith("header.seq is 0, expected 1 to "));
  writer.write(state, 7, 1, rt::now_ns() + 3600 * kSecond);
  CHECK_THAT(latest(2), Catch::StartsWith("header.time_ns in seconds is "));
  // a client on another host has another clock
  BusSettings far = test::settings(ClockMode::kRealtime, 7);
  far.shares_clock = false;
  Bus other_host(far);
  Reader<RobotState> there(other_host);
  CHECK(eventually([&] {
    writer.write(state, 7, 2, rt::now_ns() + 3600 * kSecond);
    RobotState taken{};
    return there.take(taken);
  }));
}

TEST_CASE("Reader: a request that is refused for its value is kept to be answered") {
  Bus client(test::settings()), bus(test::settings(ClockMode::kRealtime, 7));
  Reader<FaultInject> faults(bus);
  RawWriter writer(client, topic<FaultInject>());
  FaultInject fault{};
  fault.duration_s = std::nan("");
  for (std::uint64_t i = 1; i <= 10; ++i) {
    fault.request_id = i;
    writer.write(fault, 0, i);
  }
  Refusal why;
  REQUIRE(eventually([&] {
    CHECK_FALSE(faults.take(fault));
    return faults.counters().refused_for(Reason::kValue) == 10;
  }));
  // the eight newest
  for (std::uint64_t i = 3; i <= 10; ++i) {
    REQUIRE(faults.take_refused(fault, why));
    CHECK(fault.request_id == i);
    CHECK(to_text(why) == "duration_s is nan, expected 0 to 3600");
  }
  CHECK_FALSE(faults.take_refused(fault, why));
}

TEST_CASE("Replies: a refused request is answered with the reason by the process that it is for") {
  Bus client(test::settings()), bus(test::settings(ClockMode::kRealtime, 7));
  Reader<FaultInject> faults(bus);
  Reader<ServiceReply> answers(client);
  Replies plant(bus, c3rt_v2_PROCESS_PLANT), vision(bus, c3rt_v2_PROCESS_VISION);
  RawWriter writer(client, topic<FaultInject>());
  FaultInject fault{};
  fault.process = c3rt_v2_PROCESS_PLANT;
  fault.kind = c3rt_v2_FAULT_PUSH_OBJECT;
  fault.value[2] = std::nan("");
  fault.request_id = 41;
  writer.write(fault, 0, 1);
  REQUIRE(eventually([&] {
    CHECK_FALSE(faults.take(fault));
    return faults.counters().refused_for(Reason::kValue) == 1;
  }));
  plant.answer_refused(faults, kMs);
  vision.answer_refused(faults, kMs);  // it was not for vision, and has been answered
  const auto replies = take(answers, 1);
  REQUIRE(replies.size() == 1);
  CHECK(replies[0].request_id == 41);
  CHECK_FALSE(replies[0].ok);
  CHECK(std::string(replies[0].text) == "refused: value[2] is nan, expected -1000 to 1000");
}

TEST_CASE("Reader: drops what is out of order and counts gaps as lost") {
  Bus peers(test::settings()), bus(test::settings());
  Reader<RobotState> states(bus);
  RawWriter writer(peers, topic<RobotState>());
  writer.write(plain<RobotState>(), 1, 5);  // the first one heard: what was before is not a loss
  REQUIRE(take(states, 1).size() == 1);
  CHECK(states.counters().lost == 0);
  writer.write(plain<RobotState>(), 1, 8);  // 6 and 7 are missing
  REQUIRE(take(states, 1).size() == 1);
  CHECK(states.counters().lost == 2);
  writer.write(plain<RobotState>(), 1, 7);
  writer.write(plain<RobotState>(), 1, 8);
  writer.write(plain<RobotState>(), 1, 9);
  const auto samples = take(states, 1);
  REQUIRE(samples.size() == 1);
  CHECK(samples[0].header.seq == 9);
  CHECK(states.counters().refused_for(Reason::kOldSequence) == 2);
  CHECK(states.counters().lost == 2);
  CHECK(states.counters().received == 3);
}

TEST_CASE("Reader: samples of several instances come in the order in which they were written") {
  Bus peers(test::settings()), bus(test::settings());
  bus.adopt_session(1);
  Reader<ObjectDetection> detections(bus);
  RawWriter writer(peers, topic<ObjectDetection>());
  for (int i = 0; i < 12; ++i) {
    ObjectDetection detection{};
    detection.camera = i % 3;
    writer.write(detection, 1, static_cast<std::uint64_t>(i + 1));
  }
  REQUIRE(eventually([&] {
    bus.wait_for_data(10 * kMs);
    return detections.counters().received == 12;
  }));
  ObjectDetection detection{};
  for (int i = 0; i < 12; ++i) {
    REQUIRE(detections.take(detection));
    CHECK(detection.header.seq == static_cast<std::uint64_t>(i + 1));
    CHECK(detection.camera == i % 3);
  }
  CHECK(detections.counters().refused_for(Reason::kOldSequence) == 0);
}

TEST_CASE(
    "Reader: take_effective gives the newest sample whose time has come and keeps the later ones") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Writer<Plan> writer(plant);
  Reader<Plan> reader(bus);
  bus.adopt_session(1);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  auto plan = plain<Plan>();
  for (int i = 1; i <= 4; ++i) REQUIRE(writer.write(plan, i * kMs));
  REQUIRE(eventually([&] {
    bus.wait_for_data(10 * kMs);
    return reader.counters().received == 4;
  }));
  CHECK_FALSE(reader.take_effective(kMs - 1, plan));
  REQUIRE(reader.take_effective(3 * kMs - 1, plan));
  CHECK(plan.header.seq == 2);
  CHECK_FALSE(reader.take_effective(3 * kMs - 1, plan));
  REQUIRE(reader.take_effective(100 * kMs, plan));
  CHECK(plan.header.seq == 4);
}

TEST_CASE("Reader: a queue that nobody empties keeps the newest samples") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Writer<RobotState> writer(plant);
  Reader<RobotState> reader(bus, 4);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  auto state = plain<RobotState>();
  for (int i = 1; i <= 10; ++i) REQUIRE(writer.write(state, i));
  REQUIRE(eventually([&] { return reader.take(state); }));
  CHECK(state.header.seq == 7);
  while (reader.take(state)) {
  }
  CHECK(state.header.seq == 10);
}

TEST_CASE("Reader: taking does not allocate") {
  if (!support::AllocationCounter::counts()) return;
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Writer<RobotState> writer(plant);
  Reader<RobotState> reader(bus);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  auto state = plain<RobotState>();
  writer.write(state, 1);
  REQUIRE(eventually([&] { return reader.take(state); }));
  for (int i = 2; i <= 33; ++i) REQUIRE(writer.write(state, i));
  std::int64_t heap_calls = -1;
  int taken = 0;
  {
    const support::AllocationCounter heap;
    while (reader.take(state)) ++taken;
    heap_calls = heap.count();
  }
  CHECK(taken == 32);
  CHECK(heap_calls == 0);
}

TEST_CASE("Reader: refusing what was refused before does not allocate") {
  if (!support::AllocationCounter::counts()) return;
  Bus client(test::settings()), bus(test::settings(ClockMode::kRealtime, 7));
  Reader<RobotState> reader(bus);
  RawWriter writer(client, topic<RobotState>());
  auto state = plain<RobotState>();
  state.dq_rad_per_s[3] = 1e300;
  const auto refused = [&] { return reader.counters().refused_for(Reason::kValue); };
  writer.write(state, 7, 1);
  RobotState taken{};
  REQUIRE(eventually([&] { return !reader.take(taken) && refused() == 1; }));
  for (std::uint64_t seq = 2; seq <= 33; ++seq) writer.write(state, 7, seq);
  std::int64_t heap_calls = -1;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 1000 && refused() < 33; ++i) (void)reader.take(taken);
    heap_calls = heap.count();
  }
  CHECK(refused() == 33);
  CHECK(heap_calls == 0);
}

TEST_CASE("Bus: waits for data, and can be woken without any") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Writer<RobotState> writer(plant);
  Reader<RobotState> reader(bus);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  std::thread later([&] {
    usleep(20'000);
    auto state = plain<RobotState>();
    writer.write(state, 1);
  });
  const std::int64_t begin_ns = rt::now_ns();
  bus.wait_for_data(60 * kSecond);
  later.join();
  auto state = plain<RobotState>();
  CHECK(reader.take(state));
  std::thread waker([&] {
    usleep(20'000);
    bus.wake();
  });
  bus.wait_for_data(60 * kSecond);
  waker.join();
  CHECK_FALSE(reader.take(state));
  CHECK(rt::now_ns() - begin_ns < 60 * kSecond);  // neither wait ran into its limit
}

TEST_CASE(
    "Bus: wait_for names the topic whose sample does not come, and lets out nothing beyond what "
    "was promised") {
  Bus plant(test::settings(ClockMode::kLockstep, 1)), bus(test::settings(ClockMode::kLockstep));
  Writer<RobotState> writer(plant);
  Writer<Scene> scenes(plant);
  Reader<RobotState> states(bus);
  Reader<Scene> scene_reader(bus);
  bus.hold_until_promised();
  auto state = plain<RobotState>();
  for (int i = 1; i <= 3; ++i) REQUIRE(writer.write(state, i));
  Sequences promised{};
  plant.newest_written(promised);
  CHECK(promised[topic<RobotState>().stream] == 3);
  CHECK(promised[topic<Scene>().stream] == 0);
  CHECK_FALSE(states.take(state));
  promised[topic<RobotState>().stream] = 2;
  std::string missing;
  REQUIRE(bus.wait_for(promised, 10 * kSecond, missing));
  REQUIRE(states.take_newest(state));
  CHECK(state.header.seq == 2);
  promised[topic<RobotState>().stream] = 3;
  promised[topic<Scene>().stream] = 1;
  CHECK_FALSE(bus.wait_for(promised, 50 * kMs, missing));
  CHECK(missing == "sim/scene");
  auto scene = plain<Scene>();
  REQUIRE(scenes.write(scene, 1));
  CHECK(bus.wait_for(promised, 10 * kSecond, missing));
}

TEST_CASE("Bus: a peer with incompatible QoS or another type is reported by topic and process") {
  test::Child peer([] {
    Bus bus(test::settings());
    const auto topic_of = [&](const char* name, const Topic& type) {
      return dds_create_topic(bus.participant(), type.descriptor, name, nullptr, nullptr);
    };
    dds_qos_t* reliable = dds_create_qos();
    dds_qset_reliability(reliable, DDS_RELIABILITY_RELIABLE, 0);
    dds_create_reader(bus.participant(), topic_of("robot/state", topic<RobotState>()), reliable,
                      nullptr);
    dds_create_writer(bus.participant(), topic_of("plan", topic<RobotCommand>()), reliable,
                      nullptr);
    dds_create_writer(bus.participant(), topic_of("task/target", topic<TaskTarget>()), reliable,
                      nullptr);
    sleep(30);
    return 0;
  });
  Bus bus(test::settings());
  Writer<RobotState> states(bus);
  Reader<Plan> plans(bus);
  Reader<TaskTarget> targets(bus);
  Writer<Scene> scenes(bus);
  std::vector<PeerProblem> problems;
  REQUIRE(eventually([&] {
    problems = bus.problems();
    return problems.size() >= 3;
  }));
  std::map<std::string, std::string> text;
  for (const PeerProblem& problem : problems) text[problem.topic] = problem.text;
  CHECK(text.size() == 3);
  const std::string pid = "(pid " + std::to_string(peer.pid()) + ")";
  CHECK_THAT(text["robot/state"],
             Catch::Contains("requests RELIABLE, this writer offers BEST_EFFORT"));
  CHECK_THAT(text["robot/state"], Catch::Contains(pid));
  CHECK_THAT(
      text["plan"],
      Catch::Contains("has type c3rt::v2::RobotCommand, this reader has type c3rt::v2::Plan"));
  CHECK_THAT(text["task/target"],
             Catch::Contains("offers VOLATILE, this reader requests TRANSIENT_LOCAL"));
}

TEST_CASE("Bus: a peer on a misspelt topic, in a partition or with ownership is told of") {
  test::Child peer([] {
    Bus bus(test::settings());
    const auto writer = [&](const char* name, const Topic& type, auto&& change) {
      dds_qos_t* qos = dds_create_qos();
      dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, 0);
      dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
      dds_qset_liveliness(qos, DDS_LIVELINESS_AUTOMATIC, DDS_SECS(1));
      change(qos);
      dds_create_writer(
          bus.participant(),
          dds_create_topic(bus.participant(), type.descriptor, name, nullptr, nullptr), qos,
          nullptr);
      dds_delete_qos(qos);
    };
    writer("task/targets", topic<TaskTarget>(), [](dds_qos_t*) {});
    writer("fault/inject", topic<FaultInject>(),
           [](dds_qos_t* qos) { dds_qset_partition1(qos, "left"); });
    writer("plan", topic<Plan>(),
           [](dds_qos_t* qos) { dds_qset_ownership(qos, DDS_OWNERSHIP_EXCLUSIVE); });
    sleep(30);
    return 0;
  });
  Bus bus(test::settings());
  Reader<TaskTarget> targets(bus);
  Reader<FaultInject> faults(bus);
  Reader<Plan> plans(bus);
  std::map<std::string, std::string> text;
  REQUIRE(eventually([&] {
    for (const PeerProblem& problem : bus.problems()) text[problem.topic] = problem.text;
    return text.size() == 3;
  }));
  CHECK_THAT(text["task/target"],
             Catch::Contains("of the same type is on the topic task/targets") &&
                 Catch::Contains("(pid " + std::to_string(peer.pid()) + ")"));
  CHECK_THAT(text["fault/inject"],
             Catch::Contains("is in the partition left, this reader in no partition"));
  CHECK_THAT(text["plan"], Catch::Contains("offers EXCLUSIVE ownership, this reader requests "
                                           "SHARED ownership"));
}

TEST_CASE("Bus: a bystander tells which readers and writers of others can never serve each other") {
  const test::Child one([] {
    Bus bus(test::settings());
    const Writer<RobotState> states(bus);  // best effort
    const Writer<Plan> plans(bus);
    sleep(30);
    return 0;
  });
  const test::Child other([] {
    Bus bus(test::settings());
    dds_qos_t* reliable = dds_create_qos();
    dds_qset_reliability(reliable, DDS_RELIABILITY_RELIABLE, 0);
    dds_create_reader(bus.participant(),
                      dds_create_topic(bus.participant(), topic<RobotState>().descriptor,
                                       "robot/state", nullptr, nullptr),
                      reliable, nullptr);
    dds_delete_qos(reliable);
    const Reader<Plan> plans(bus);
    sleep(30);
    return 0;
  });
  const Bus bus(test::settings());
  std::vector<PeerProblem> found;
  REQUIRE(eventually([&] { return !(found = peer_disagreements(bus)).empty(); }));
  REQUIRE(found.size() == 1);
  CHECK(found[0].topic == "robot/state");
  CHECK_THAT(found[0].text,
             Catch::Contains("(pid " + std::to_string(one.pid()) + ") offers BEST_EFFORT") &&
                 Catch::Contains("(pid " + std::to_string(other.pid()) + ") requests RELIABLE"));
}

TEST_CASE(
    "Bus: processes of the same clock have no problem with each other, and a realtime client can "
    "listen to both") {
  for (const ClockMode clock : {ClockMode::kRealtime, ClockMode::kLockstep}) {
    Bus plant(test::settings(clock, 1)), peer(test::settings(clock)), client(test::settings());
    Writer<RobotState> a(plant);
    Writer<Plan> b(plant);
    Writer<ServiceStatus> c(plant);
    Writer<Scene> d(plant);
    Writer<ObjectEstimate> e(plant);
    Reader<RobotState> a_peer(peer), a_client(client);
    Reader<Plan> b_peer(peer), b_client(client);
    Reader<ServiceStatus> c_peer(peer), c_client(client);
    Reader<Scene> d_peer(peer), d_client(client);
    Reader<ObjectEstimate> e_peer(peer), e_client(client);
    CHECK(eventually([&] {
      return a.matched_readers() == 2 && b.matched_readers() == 2 && c.matched_readers() == 2 &&
             d.matched_readers() == 2 && e.matched_readers() == 2;
    }));
    CHECK(plant.problems().empty());
    CHECK(client.problems().empty());
  }
}

TEST_CASE("Writer: what is addressed to one process reaches it and who reads all, nobody else") {
  Bus plant(test::settings(ClockMode::kLockstep, 1)), planner(test::settings(ClockMode::kLockstep)),
      vision(test::settings(ClockMode::kLockstep)), client(test::settings());
  Writer<Tick> to_planner(plant, c3rt_v2_PROCESS_PLANNER), to_vision(plant, c3rt_v2_PROCESS_VISION);
  Reader<Tick> at_planner(planner, 64, Wakes::kBus, c3rt_v2_PROCESS_PLANNER),
      at_vision(vision, 64, Wakes::kBus, c3rt_v2_PROCESS_VISION), at_client(client);
  REQUIRE(eventually(
      [&] { return to_planner.matched_readers() == 2 && to_vision.matched_readers() == 2; }));
  Tick tick{};
  REQUIRE(to_planner.write(tick, 1 * kMs));
  REQUIRE(to_vision.write(tick, 2 * kMs));
  REQUIRE(to_planner.write(tick, 3 * kMs));
  const auto times = [](Reader<Tick>& reader, std::size_t count) {
    std::vector<std::int64_t> seen;
    Tick taken{};
    (void)eventually([&] {
      while (reader.take(taken)) seen.push_back(taken.header.time_ns / kMs);
      return seen.size() >= count;
    });
    std::sort(seen.begin(), seen.end());
    return seen;
  };
  CHECK(times(at_client, 3) == std::vector<std::int64_t>{1, 2, 3});
  CHECK(times(at_planner, 2) == std::vector<std::int64_t>{1, 3});
  CHECK(times(at_vision, 1) == std::vector<std::int64_t>{2});
  // that the others do not meet is no problem between them
  for (const Bus* bus : {&plant, &planner, &client}) (void)bus->problems();
  usleep(2'200'000);  // longer than a match may take
  CHECK(plant.problems().empty());
  CHECK(planner.problems().empty());
  CHECK(client.problems().empty());
}

TEST_CASE("Bus: of clients that have come and gone nothing is kept") {
  constexpr int kClients = 20;
  test::Child clients([] {
    for (int i = 0; i < kClients; ++i) {
      Bus client(test::settings());
      Reader<RobotState> states(client);
      if (!eventually([&] { return states.matched_writers() == 1; })) return 1;
    }
    return 0;
  });
  Bus bus(test::settings());
  Writer<RobotState> states(bus);
  // what Cyclone has of built-in topics in this process: living, or left by somebody who has gone
  const auto children = [](dds_entity_t parent) {
    std::vector<dds_entity_t> found(100);
    found.resize(std::max(0, dds_get_children(parent, found.data(), found.size())));
    return found;
  };
  const auto instances = [&](std::uint32_t which) {
    std::vector<void*> samples(4096);  // as idl/peers.cpp: Cyclone fills as many as were ever lent
    std::vector<dds_sample_info_t> info(samples.size());
    int found = 0;
    for (const dds_entity_t subscriber : children(bus.participant())) {
      for (const dds_entity_t reader : children(subscriber)) {
        char topic[64] = "";
        if (dds_get_name(dds_get_topic(reader), topic, sizeof topic) < 0 ||
            std::strncmp(topic, "DCPS", 4) != 0)
          continue;
        std::fill(samples.begin(), samples.end(), nullptr);
        const dds_return_t read =
            dds_read_mask(reader, samples.data(), info.data(), samples.size(), 4096,
                          DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | which);
        if (read <= 0) continue;
        found += read;
        dds_return_loan(reader, samples.data(), read);
      }
    }
    return found;
  };
  REQUIRE(clients.wait() == 0);
  constexpr std::uint32_t kGone = DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE;
  // of each its participant and its reader, but one that goes at once may be heard of in part only
  REQUIRE(eventually([&] { return instances(kGone) >= kClients; }));
  CHECK(bus.problems().empty());
  CHECK(instances(kGone) == 0);
  CHECK(instances(DDS_ALIVE_INSTANCE_STATE) > 0);
}

TEST_CASE("Bus: every profile that is shipped opens a bus") {
  std::uint32_t domain = 102;  // a profile is read when a domain is opened first
  for (const char* name : {"loopback", "lan"}) {
    INFO(name);
    BusSettings settings;
    settings.domain = domain++;
    settings.profile_uri = C3RT_SOURCE_DIRECTORY "/config/dds/" + std::string(name) + ".xml";
    CHECK_NOTHROW(Bus(settings));
  }
}

TEST_CASE("Bus: a profile that is missing or wrong is an error that names it") {
  BusSettings settings = test::settings();
  settings.domain = 101;
  settings.profile_uri = "no/such/profile.xml";
  CHECK_THROWS_WITH(Bus(settings),
                    Catch::Contains("no/such/profile.xml") && Catch::Contains("No such file"));
  settings.profile_uri = C3RT_SOURCE_DIRECTORY "/.clang-format";  // a file, but not XML
  CHECK_THROWS_AS(Bus(settings), WireError);
}

}  // namespace
