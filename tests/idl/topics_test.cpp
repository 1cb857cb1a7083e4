#include "idl/topics.hpp"

#include <cstring>
#include <map>
#include <set>
#include <string>

#include <catch2/catch.hpp>

namespace c3rt::wire {
namespace {

// the sizes that the model and the planner are built for stand in the contract, not only in the
// code
static_assert(sizeof(Plan::x) == c3rt_v1_MAX_HORIZON * c3rt_v1_MAX_STATES * sizeof(double));
static_assert(sizeof(Plan::lambda) == c3rt_v1_MAX_HORIZON * c3rt_v1_MAX_FORCES * sizeof(double));
static_assert(sizeof(Plan::u) == c3rt_v1_MAX_HORIZON * c3rt_v1_MAX_INPUTS * sizeof(double));
static_assert(sizeof(Tick::newest_seq) == sizeof(Done::newest_seq));
static_assert(sizeof(Tick::newest_seq) == c3rt_v1_TOPIC_COUNT * sizeof(std::uint64_t));
static_assert(sizeof(ServiceStatus::counters) == c3rt_v2_COUNTERS * sizeof(std::uint64_t));

template <typename... T>
std::map<std::string, const Topic*> table() {
  return {{topic<T>().name, &topic<T>()}...};
}
const auto kTopics =
    table<RobotState, RobotCommand, Plan, BallDetection, BallEstimate, TaskTarget, Scene, Tick,
          Done, ServiceStatus, ServiceRequest, ServiceReply, FaultInject>();

TEST_CASE("topics: the names are those of the contract, each once") {
  std::set<std::string> names;
  for (const auto& [name, topic] : kTopics) names.insert(name);
  CHECK(names == std::set<std::string>{"robot/state", "robot/command", "plan", "ball/detection",
                                       "ball/estimate", "task/target", "sim/scene", "sim/tick",
                                       "sim/done", "service/status", "service/request",
                                       "service/reply", "fault/inject"});
}

TEST_CASE("topics: no two topics share a type or a place in a tick") {
  std::set<const void*> types;
  std::set<int> places;
  for (const auto& [name, topic] : kTopics) {
    INFO(name);
    CHECK(types.insert(topic->descriptor).second);
    if (topic->stream == Stream::kNone) continue;
    CHECK(places.insert(static_cast<int>(topic->stream)).second);
    CHECK(static_cast<int>(topic->stream) < c3rt_v1_TOPIC_COUNT);
  }
}

TEST_CASE("topics: every sample that crosses the network begins with a key or the header") {
  // DESIGN, section 2: the keyed topics
  const std::set<std::string> keyed = {"robot/state",    "robot/command",   "plan",
                                       "ball/detection", "ball/estimate",   "sim/done",
                                       "service/status", "service/request", "service/reply",
                                       "fault/inject"};
  for (const auto& [name, topic] : kTopics) {
    INFO(name);
    CHECK((topic->descriptor->m_nkeys > 0) == (keyed.count(name) == 1));
  }
}

TEST_CASE("topics: the version of the contract is in every type's name") {
  for (const auto& [name, topic] : kTopics)
    CHECK_THAT(std::string(topic->descriptor->m_typename),
               Catch::StartsWith("c3rt::v1::") || Catch::StartsWith("c3rt::v2::"));
}

TEST_CASE("process_name: every process has one") {
  std::set<std::string> names;
  for (int i = 0; i < kProcessCount; ++i) names.insert(process_name(static_cast<Process>(i)));
  CHECK(names == std::set<std::string>{"plant", "impedance", "planner", "vision", "recorder"});
}

}  // namespace
}  // namespace c3rt::wire
