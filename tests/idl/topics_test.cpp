#include "idl/topics.hpp"

#include <cstring>
#include <map>
#include <set>
#include <string>
#include <type_traits>

#include <catch2/catch.hpp>

#include "controller/scene/scene.hpp"

using namespace c3rt;
using namespace c3rt::wire;

namespace {

// the sizes that the model and the planner are built for stand in the contract, not only in the
// code
static_assert(c3rt_v2_HORIZON_STATES == c3rt_v2_MAX_HORIZON * c3rt_v2_MAX_STATES);
static_assert(c3rt_v2_HORIZON_FORCES == c3rt_v2_MAX_HORIZON * c3rt_v2_MAX_FORCES);
static_assert(c3rt_v2_HORIZON_INPUTS == c3rt_v2_MAX_HORIZON * c3rt_v2_MAX_INPUTS);
static_assert(c3rt_v2_MAX_OBJECTS == scene::kMaxBodies, "one capacity");
static_assert(sizeof(Tick::newest_seq) == sizeof(Done::newest_seq));
static_assert(sizeof(Tick::newest_seq) == c3rt_v2_TOPIC_COUNT * sizeof(std::uint64_t));
static_assert(sizeof(ServiceStatus::counters) == c3rt_v2_COUNTERS * sizeof(std::uint64_t));

std::map<std::string, const Topic*> table_by_name() {
  std::map<std::string, const Topic*> topics;
  for (const Topic& topic : table::kTopics) topics[topic.name] = &topic;
  return topics;
}
const auto kTopics = table_by_name();

TEST_CASE("topics: the names are those of the contract, each once") {
  std::set<std::string> names;
  for (const auto& [name, topic] : kTopics) names.insert(name);
  CHECK(names == std::set<std::string>{
                     "robot/state", "robot/contact", "robot/command", "robot/motion", "robot/order",
                     "plan", "planner/debug", "planner/weights", "object/detection",
                     "object/estimate", "task/target", "sim/scene", "sim/tick", "sim/done",
                     "service/status", "service/request", "service/reply", "fault/inject"});
}

TEST_CASE("topics: a type has its own line of the table") {
  CHECK(kTopics.size() == table::kTopics.size());
  CHECK(topic<Plan>().name == std::string("plan"));
  CHECK(topic<Plan>().writer == c3rt_v2_PROCESS_PLANNER);
  CHECK(topic<Tick>().trait == Trait::kAddressed);
  int topics = 0;
  for_each_topic([&](const auto& sample) {
    const Topic& one = topic<std::decay_t<decltype(sample)>>();
    CHECK(&one == &table::kTopics[static_cast<std::size_t>(topics++)]);
    bool found = false;
    CHECK(with_topic(one.name, [&](const auto& same) {
      found = std::is_same_v<decltype(same), decltype(sample)>;
    }));
    CHECK(found);
  });
  CHECK(topics == static_cast<int>(kTopics.size()));
  CHECK_FALSE(with_topic("robot", [](const auto&) {}));
}

TEST_CASE("topics: a tick's places of streams are those that clients of version 0.12 know") {
  CHECK(topic<Scene>().stream == 0);
  CHECK(topic<RobotState>().stream == 1);
  CHECK(topic<RobotCommand>().stream == 2);
  CHECK(topic<Plan>().stream == 3);
  CHECK(topic<ObjectEstimate>().stream == 4);
  CHECK(topic<ObjectDetection>().stream == 5);
  CHECK(topic<PlannerDebug>().stream == 6);
  CHECK(topic<RobotMotion>().stream == 7);
}

TEST_CASE("topics: streams are those that a recorder keeps and lockstep waits for") {
  for (const Topic& topic : table::kTopics) {
    INFO(topic.name);
    CHECK((topic.stream != kNoStream) == (topic.qos == Qos::kStream || topic.qos == Qos::kPlan));
  }
}

/// A field's name and size in bytes, as a visitor sees them.
struct Seen {
  template <typename T>
  void operator()(const char* name, const T& value) {
    names.insert(name);
    bytes += sizeof value;
  }
  template <typename T>
  void list(const char* name, const T& values, int) {
    (*this)(name, values);
  }
  void machine_time(const char* name, const double& value) { (*this)(name, value); }
  std::set<std::string> names;
  std::size_t bytes = 0;
};

TEST_CASE("fields: every field of every topic's type is visited once, under its own name") {
  for_each_topic([](const auto& sample) {
    Seen seen;
    visit_fields(sample, seen);
    INFO(topic<std::decay_t<decltype(sample)>>().name);
    CHECK(seen.names.count("header") == 1);
    // what is missing is padding: less than eight bytes for each field
    CHECK(seen.bytes <= sizeof sample);
    CHECK(seen.bytes + 7 * seen.names.size() >= sizeof sample);
  });
}

TEST_CASE("enumerators: the word is what is left without what all of them begin with") {
  CHECK(name_of(c3rt_v2_ROBOT_USER_STOPPED) == std::string("user stopped"));
  CHECK(name_of(c3rt_v2_IMPEDANCE_TRACK) == std::string("track"));
  CHECK(enumerators(c3rt_v2_ROBOT_IDLE) == 4);
}

TEST_CASE("topics: no two topics share a type or a place in a tick") {
  std::set<const void*> types;
  std::set<int> places;
  for (const auto& [name, topic] : kTopics) {
    INFO(name);
    CHECK(types.insert(topic->descriptor).second);
    if (topic->stream == kNoStream) continue;
    CHECK(places.insert(topic->stream).second);
    CHECK(topic->stream < c3rt_v2_TOPIC_COUNT);
  }
}

TEST_CASE("topics: every sample that crosses the network begins with a key or the header") {
  // DESIGN, section 2: the keyed topics
  const std::set<std::string> keyed = {
      "robot/state",    "robot/contact",   "robot/command",    "robot/motion",    "robot/order",
      "plan",           "planner/debug",   "object/detection", "object/estimate", "sim/done",
      "service/status", "service/request", "service/reply",    "fault/inject"};
  for (const auto& [name, topic] : kTopics) {
    INFO(name);
    CHECK((topic->descriptor->m_nkeys > 0) == (keyed.count(name) == 1));
  }
}

TEST_CASE("topics: the version of the contract is in every type's name") {
  for (const auto& [name, topic] : kTopics)
    CHECK_THAT(std::string(topic->descriptor->m_typename), Catch::StartsWith("c3rt::v2::"));
}

TEST_CASE("process_name: every process has one") {
  std::set<std::string> names;
  for (int i = 0; i < kProcessCount; ++i) names.insert(process_name(static_cast<Process>(i)));
  CHECK(names == std::set<std::string>{"plant", "impedance", "planner", "vision", "recorder"});
}

}  // namespace
