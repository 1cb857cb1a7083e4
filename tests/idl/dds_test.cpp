#include "idl/dds.hpp"

#include <cstring>
#include <map>
#include <thread>

#include <catch2/catch.hpp>
#include <dds/dds.h>

#include "tests/idl/bus_fixture.hpp"
#include "tests/support/allocation_counter.hpp"

namespace c3rt::wire {
namespace {

using test::eventually;
using test::kMs;
using test::kSecond;

/// A writer that fills in nothing: session and sequence are the test's.
class RawWriter {
 public:
  RawWriter(const Bus& bus, const Topic& topic, bool reliable = true) {
    const dds_entity_t handle =
        dds_create_topic(bus.participant(), topic.descriptor, topic.name, nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    if (reliable) dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_liveliness(qos, DDS_LIVELINESS_AUTOMATIC, DDS_SECS(5));
    dds_qset_deadline(qos, DDS_MSECS(1));
    writer_ = dds_create_writer(bus.participant(), handle, qos, nullptr);
    dds_delete_qos(qos);
  }
  template <typename T>
  void write(T sample, std::uint64_t session, std::uint64_t seq) {
    sample.header = {session, seq, 0};
    REQUIRE(dds_write(writer_, &sample) == DDS_RETCODE_OK);
  }

 private:
  dds_entity_t writer_;
};

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

/// A sample with something in its fields; unique types and extreme values where they are cheap.
template <typename T>
T filled();
template <>
RobotState filled() {
  RobotState sample{};
  sample.robot = 1;
  for (int i = 0; i < 7; ++i) sample.q_rad[i] = 0.1 * i;
  for (int i = 0; i < 7; ++i) sample.tau_nm[i] = -1.5 * i;
  for (int i = 0; i < 4; ++i) sample.q_WE[i] = i;
  sample.mode = c3rt_v1_ROBOT_REFLEX;
  sample.errors = 1ull << 63;
  sample.command_state_ns = -5;
  return sample;
}
template <>
RobotCommand filled() {
  RobotCommand sample{};
  sample.origin = {1, 2, 3, 4};
  sample.mode = c3rt_v1_IMPEDANCE_STOP;
  for (int i = 0; i < 3; ++i) sample.v_WE_desired_m_per_s[i] = i - 0.25;
  return sample;
}
template <>
Plan filled() {
  Plan sample{};
  sample.status = c3rt_v1_PLAN_FALLBACK;
  sample.phase = c3rt_v1_PHASE_HOLD;
  for (int k = 0; k < c3rt_v1_MAX_HORIZON; ++k) {
    for (int i = 0; i < c3rt_v1_MAX_STATES; ++i) sample.x[k][i] = k + 0.01 * i;
    for (int i = 0; i < c3rt_v1_MAX_FORCES; ++i) sample.lambda[k][i] = -k - 0.01 * i;
    for (int i = 0; i < c3rt_v1_MAX_INPUTS; ++i) sample.u[k][i] = 100 + k + 0.1 * i;
  }
  sample.complementarity_violation = 1e-300;
  return sample;
}
template <>
BallDetection filled() {
  BallDetection sample{};
  sample.camera = 2;
  sample.ball = 3;
  sample.used = true;
  sample.radius_px = 17.25;
  return sample;
}
template <>
BallEstimate filled() {
  BallEstimate sample{};
  sample.ball = 1;
  sample.valid = true;
  for (int i = 0; i < 4; ++i) sample.q_WB[i] = -i;
  return sample;
}
template <>
TaskTarget filled() {
  TaskTarget sample{};
  sample.kind = c3rt_v1_TARGET_POINT;
  sample.request_id = 78;
  sample.lead_rad = -0.5;
  return sample;
}
template <>
Scene filled() {
  Scene sample{};
  sample.exposure = true;
  sample.ball_count = 2;
  for (int b = 0; b < c3rt_v1_MAX_BALLS; ++b) {
    for (int i = 0; i < 3; ++i) sample.p_WB_m[b][i] = b + 0.1 * i;
  }
  return sample;
}
template <>
Done filled() {
  Done sample{};
  sample.process = c3rt_v1_PROCESS_VISION;
  sample.next_due_ns = 1'234'567'890'123;
  sample.newest_seq[7] = 9;
  return sample;
}
template <>
ServiceStatus filled() {
  ServiceStatus sample{};
  sample.process = c3rt_v1_PROCESS_PLANNER;
  sample.state = c3rt_v1_SERVICE_DEGRADED;
  std::strcpy(sample.text, "one sentence");
  std::strcpy(sample.counter_names[31], "thirty-one letters, no more....");
  sample.counters[31] = ~0ull;
  std::strcpy(sample.refused[15].topic, "robot/command");
  std::strcpy(sample.refused[15].latest, std::string(255, 'w').c_str());
  sample.refused[15].count = 3;
  sample.compute.p999_s = 1e-3;
  return sample;
}
template <>
ServiceRequest filled() {
  ServiceRequest sample{};
  sample.request_id = 77;
  sample.verb = c3rt_v1_REQUEST_STOP;
  return sample;
}
template <>
ServiceReply filled() {
  ServiceReply sample{};
  sample.request_id = 77;
  sample.ok = true;
  std::strcpy(sample.text, std::string(511, 'd').c_str());
  return sample;
}
template <>
FaultInject filled() {
  FaultInject sample{};
  sample.process = c3rt_v1_PROCESS_RECORDER;
  sample.request_id = 79;
  sample.kind = c3rt_v1_FAULT_NAN;
  sample.value[2] = 0.125;
  return sample;
}
template <>
Tick filled() {
  Tick sample{};
  sample.due = 0x80000001u;
  for (int i = 0; i < c3rt_v1_TOPIC_COUNT; ++i)
    sample.newest_seq[i] = static_cast<std::uint64_t>(i) << 40;
  return sample;
}

TEMPLATE_TEST_CASE("wire: what is written in one process is read in another, bit by bit", "",
                   RobotState, RobotCommand, Plan, BallDetection, BallEstimate, TaskTarget, Scene,
                   Tick, Done, ServiceStatus, ServiceRequest, ServiceReply, FaultInject) {
  constexpr std::uint64_t kSession = 42;
  // in lockstep every topic is reliable, so a write before the reader is found is not lost
  test::Child child([] {
    Bus bus(test::settings(ClockMode::kLockstep, kSession));
    Writer<TestType> writer(bus);
    TestType sample = filled<TestType>();
    for (int i = 1; i <= 3; ++i) {
      if (!writer.write(sample, i * kMs)) return 1;
    }
    return eventually([&] { return writer.matched_readers() > 0; }) && (sleep(20), true) ? 0 : 2;
  });
  Bus bus(test::settings(ClockMode::kLockstep));
  bus.adopt_session(kSession);
  Reader<TestType> reader(bus);
  const auto samples = take(reader, topic<TestType>().qos == Qos::kStatus ? 1 : 3);
  REQUIRE(samples.size() >= 1);
  TestType expected = filled<TestType>();
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

TEST_CASE("Reader: adopts the newest session of the plant and drops samples of an older one") {
  Bus plants(test::settings()), bus(test::settings());
  Reader<RobotState> states(bus);
  RawWriter writer(plants, topic<RobotState>());
  RobotState state{};
  writer.write(state, 100, 1);
  REQUIRE(take(states, 1).size() == 1);
  CHECK(bus.session_id() == 100);
  writer.write(state, 200, 2);
  writer.write(state, 100, 3);
  writer.write(state, 200, 4);
  const auto samples = take(states, 2);
  REQUIRE(samples.size() == 2);
  CHECK(samples[0].header.seq == 2);
  CHECK(samples[1].header.seq == 4);
  CHECK(bus.session_id() == 200);
  CHECK(states.counters().other_session == 1);
}

TEST_CASE("Reader: a newer session may be heard from any process first, but a client starts none") {
  Bus peers(test::settings()), bus(test::settings());
  Reader<Plan> plans(bus);
  Reader<TaskTarget> targets(bus);
  RawWriter plan_writer(peers, topic<Plan>()), target_writer(peers, topic<TaskTarget>());
  target_writer.write(TaskTarget{}, 500, 1);
  target_writer.write(TaskTarget{}, 0, 2);
  CHECK(take(targets, 2).size() == 2);
  CHECK(bus.session_id() == 0);
  // in lockstep the plan of a tick may arrive before the tick itself: it must not be lost
  plan_writer.write(Plan{}, 300, 1);
  CHECK(take(plans, 1).size() == 1);
  CHECK(bus.session_id() == 300);
  target_writer.write(TaskTarget{}, 200, 3);
  target_writer.write(TaskTarget{}, 300, 4);
  const auto samples = take(targets, 1);
  REQUIRE(samples.size() == 1);
  CHECK(samples[0].header.seq == 4);
  CHECK(targets.counters().other_session == 1);
}

TEST_CASE("Reader: the plant keeps its own session, whatever others claim") {
  Bus peers(test::settings()), plant(test::settings(ClockMode::kRealtime, 100));
  Reader<RobotState> states(plant);
  RawWriter writer(peers, topic<RobotState>());
  writer.write(RobotState{}, 500, 1);
  writer.write(RobotState{}, 100, 2);
  REQUIRE(take(states, 1).size() == 1);
  CHECK(plant.session_id() == 100);
}

TEST_CASE("Reader: a plan queued before the plant restarted is not given out after") {
  Bus peers(test::settings()), bus(test::settings());
  bus.adopt_session(100);
  Reader<Plan> plans(bus);
  RawWriter writer(peers, topic<Plan>());
  writer.write(Plan{}, 100, 1);
  REQUIRE(eventually([&] {
    bus.wait_for_data(10 * kMs);  // moves it to the queue
    return plans.counters().received == 1;
  }));
  bus.adopt_session(200);
  Plan plan{};
  CHECK_FALSE(plans.take(plan));
  CHECK(plans.counters().other_session == 1);
}

TEST_CASE("Reader: drops what is out of order and counts gaps as lost") {
  Bus peers(test::settings()), bus(test::settings());
  Reader<RobotState> states(bus);
  RawWriter writer(peers, topic<RobotState>());
  writer.write(RobotState{}, 1, 5);  // the first one heard: what was before is not a loss
  REQUIRE(take(states, 1).size() == 1);
  CHECK(states.counters().lost == 0);
  writer.write(RobotState{}, 1, 8);  // 6 and 7 are missing
  REQUIRE(take(states, 1).size() == 1);
  CHECK(states.counters().lost == 2);
  writer.write(RobotState{}, 1, 7);
  writer.write(RobotState{}, 1, 8);
  writer.write(RobotState{}, 1, 9);
  const auto samples = take(states, 1);
  REQUIRE(samples.size() == 1);
  CHECK(samples[0].header.seq == 9);
  CHECK(states.counters().out_of_order == 2);
  CHECK(states.counters().lost == 2);
  CHECK(states.counters().received == 3);
}

TEST_CASE("Reader: samples of several instances come in the order in which they were written") {
  Bus peers(test::settings()), bus(test::settings());
  bus.adopt_session(1);
  Reader<BallDetection> detections(bus);
  RawWriter writer(peers, topic<BallDetection>());
  for (int i = 0; i < 12; ++i) {
    BallDetection detection{};
    detection.camera = i % 3;
    writer.write(detection, 1, static_cast<std::uint64_t>(i + 1));
  }
  REQUIRE(eventually([&] {
    bus.wait_for_data(10 * kMs);
    return detections.counters().received == 12;
  }));
  BallDetection detection{};
  for (int i = 0; i < 12; ++i) {
    REQUIRE(detections.take(detection));
    CHECK(detection.header.seq == static_cast<std::uint64_t>(i + 1));
    CHECK(detection.camera == i % 3);
  }
  CHECK(detections.counters().out_of_order == 0);
}

TEST_CASE(
    "Reader: take_effective gives the newest sample whose time has come and keeps the later ones") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Writer<Plan> writer(plant);
  Reader<Plan> reader(bus);
  bus.adopt_session(1);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  Plan plan{};
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
  RobotState state{};
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
  RobotState state{};
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

TEST_CASE("Bus: waits for data, and can be woken without any") {
  Bus plant(test::settings(ClockMode::kRealtime, 1)), bus(test::settings());
  Writer<RobotState> writer(plant);
  Reader<RobotState> reader(bus);
  REQUIRE(eventually([&] { return writer.matched_readers() == 1; }));
  std::thread later([&] {
    usleep(20'000);
    RobotState state{};
    writer.write(state, 1);
  });
  const std::int64_t begin_ns = rt::now_ns();
  bus.wait_for_data(60 * kSecond);
  later.join();
  RobotState state{};
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
  RobotState state{};
  for (int i = 1; i <= 3; ++i) REQUIRE(writer.write(state, i));
  Sequences promised{};
  plant.newest_written(promised);
  CHECK(promised[static_cast<int>(Stream::kRobotState)] == 3);
  CHECK(promised[static_cast<int>(Stream::kScene)] == 0);
  CHECK_FALSE(states.take(state));
  promised[static_cast<int>(Stream::kRobotState)] = 2;
  std::string missing;
  REQUIRE(bus.wait_for(promised, 10 * kSecond, missing));
  REQUIRE(states.take_newest(state));
  CHECK(state.header.seq == 2);
  promised[static_cast<int>(Stream::kRobotState)] = 3;
  promised[static_cast<int>(Stream::kScene)] = 1;
  CHECK_FALSE(bus.wait_for(promised, 50 * kMs, missing));
  CHECK(missing == "sim/scene");
  Scene scene{};
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
      Catch::Contains("has type c3rt::v1::RobotCommand, this reader has type c3rt::v1::Plan"));
  CHECK_THAT(text["task/target"],
             Catch::Contains("offers VOLATILE, this reader requests TRANSIENT_LOCAL"));
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
    Writer<BallEstimate> e(plant);
    Reader<RobotState> a_peer(peer), a_client(client);
    Reader<Plan> b_peer(peer), b_client(client);
    Reader<ServiceStatus> c_peer(peer), c_client(client);
    Reader<Scene> d_peer(peer), d_client(client);
    Reader<BallEstimate> e_peer(peer), e_client(client);
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
  Writer<Tick> to_planner(plant, c3rt_v1_PROCESS_PLANNER), to_vision(plant, c3rt_v1_PROCESS_VISION);
  Reader<Tick> at_planner(planner, 64, Wakes::kBus, c3rt_v1_PROCESS_PLANNER),
      at_vision(vision, 64, Wakes::kBus, c3rt_v1_PROCESS_VISION), at_client(client);
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
}  // namespace c3rt::wire
