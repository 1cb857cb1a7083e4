#pragma once
// Every topic in one table. A new topic is a struct in c3rt.idl and a line here (and its ranges in
// validate.cpp, where it has some): its type, what readers and writers do with it, echo, hz,
// topics, recorder and the tests follow from them.
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "c3rt.h"         // generated from idl/c3rt.idl
#include "c3rt_fields.h"  // the same: the fields of its structs by name

namespace c3rt::wire {

using Header = c3rt_v2_Header;
using Origin = c3rt_v2_Origin;
using Quantiles = c3rt_v2_Quantiles;
using RefusedSamples = c3rt_v2_RefusedSamples;
using Process = c3rt_v2_Process;

constexpr int kProcessCount = enumerators(Process{});
/// "plant", "impedance", "planner", "vision", "recorder"
inline const char* process_name(Process process) { return name_of(process); }

/// How a topic behaves on the network; the numbers stand in qos.cpp, once.
enum class Qos {
  kStream,  // best effort, keep last 1; in lockstep reliable, so that no sample can be lost
  kPlan,    // reliable, keep last 1, liveliness
  kEvent,   // reliable, transient local, keep last 16
  kStatus,  // reliable, transient local, keep last 1, liveliness
  kSync,    // reliable, keep last 256: lockstep only
};

/// What is special about a topic.
enum class Trait {
  kNone,
  kAddressed,  // each sample is for one process: writers and readers may name it, and then it costs
               // nobody else anything. Who names no process writes to and reads of all.
  kAnswered,   // a request: what is refused is kept, so that it can be answered
};

constexpr int kNoStream = -1;

struct Topic {
  const char* name;
  const dds_topic_descriptor_t* descriptor;
  Qos qos;
  /// The one process that writes it, where there must be only one: what moves the robot and what
  /// that is made from. A reader obeys one writer (one_writer.hpp), in the plant's session alone;
  /// others are refused and named.
  std::optional<Process> writer;
  double deadline_s;  // 0: none. Requested and offered where the topic is periodic (realtime only).
  Trait trait;
  /// Index into Tick.newest_seq of the topics that are recorded, and that lockstep waits for: those
  /// of the qualities kStream and kPlan.
  int stream = kNoStream;
};

namespace table {

constexpr std::nullopt_t kMany = std::nullopt;  // clients, or every process
constexpr Process kPlant = c3rt_v2_PROCESS_PLANT;
constexpr Process kImpedance = c3rt_v2_PROCESS_IMPEDANCE;
constexpr Process kPlanner = c3rt_v2_PROCESS_PLANNER;
constexpr Process kVision = c3rt_v2_PROCESS_VISION;

}  // namespace table

// clang-format off
//      type,                name               quality  writer      deadline  trait          // readers and rate
#define C3RT_TOPICS(TOPIC)                                                                                              \
  TOPIC(Scene,           "sim/scene",        kStream, kPlant,     0.0,      kNone)      /* vision; >= 100 Hz */       \
  TOPIC(RobotState,      "robot/state",      kStream, kPlant,     0.02,     kNone)      /* all; 1 kHz */              \
  TOPIC(RobotCommand,    "robot/command",    kStream, kImpedance, 0.02,     kNone)      /* plant; 1 kHz */            \
  TOPIC(Plan,            "plan",             kPlan,   kPlanner,   0.0,      kNone)      /* impedance; fixed rate */   \
  TOPIC(ObjectEstimate,  "object/estimate",  kStream, kVision,    0.1,      kNone)      /* planner; >= 80 Hz */       \
  TOPIC(ObjectDetection, "object/detection", kStream, kVision,    0.0,      kNone)      /* clients; camera rate */    \
  TOPIC(PlannerDebug,    "planner/debug",    kStream, kPlanner,   0.0,      kNone)      /* clients; as plan */        \
  TOPIC(TaskTarget,      "task/target",      kEvent,  kMany,      0.0,      kAnswered)  /* planner; on change */      \
  TOPIC(Tick,            "sim/tick",         kSync,   kPlant,     0.0,      kAddressed) /* all; lockstep */           \
  TOPIC(Done,            "sim/done",         kSync,   kMany,      0.0,      kNone)      /* plant; lockstep */         \
  TOPIC(ServiceStatus,   "service/status",   kStatus, kMany,      0.0,      kNone)      /* clients; 10 Hz */          \
  TOPIC(ServiceRequest,  "service/request",  kEvent,  kMany,      0.0,      kAnswered)  /* all; on demand */          \
  TOPIC(ServiceReply,    "service/reply",    kEvent,  kMany,      0.0,      kNone)      /* clients; on demand */      \
  TOPIC(FaultInject,     "fault/inject",     kEvent,  kMany,      0.0,      kAnswered)  /* all; on demand */
// clang-format on

#define C3RT_TOPIC(Type, ...) using Type = c3rt_v2_##Type;
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

namespace table {

enum Place {
#define C3RT_TOPIC(Type, ...) kPlaceOf##Type,
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
      kCount
};

template <typename T>
struct PlaceOf;
template <int place>
struct TypeAt;
#define C3RT_TOPIC(Type, ...)                    \
  template <>                                    \
  struct PlaceOf<Type> {                         \
    static constexpr int value = kPlaceOf##Type; \
  };                                             \
  template <>                                    \
  struct TypeAt<kPlaceOf##Type> {                \
    using type = Type;                           \
  };
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

constexpr std::array<Topic, kCount> make() {
  std::array<Topic, kCount> topics = {{
#define C3RT_TOPIC(Type, name, quality, writer, deadline, trait) \
  Topic{name, &c3rt_v2_##Type##_desc, Qos::quality, writer, deadline, Trait::trait},
      C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  }};
  int streams = 0;
  for (Topic& topic : topics) {
    if (topic.qos == Qos::kStream || topic.qos == Qos::kPlan) topic.stream = streams++;
  }
  return topics;
}
inline constexpr std::array<Topic, kCount> kTopics = make();

template <int... place>
std::tuple<typename TypeAt<place>::type...> types(std::integer_sequence<int, place...>);

}  // namespace table

template <typename T>
constexpr const Topic& topic() {
  return table::kTopics[table::PlaceOf<T>::value];
}

/// The types of all topics, in the order of the table.
using TopicTypes = decltype(table::types(std::make_integer_sequence<int, table::kCount>{}));

/// Calls `action` with a default sample of every topic's type, in the order of the table.
template <typename Action>
void for_each_topic(Action&& action) {
#define C3RT_TOPIC(Type, ...) action(Type{});
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
}

/// Calls `action` with a default sample of the topic's type. @return false if there is no topic of
/// this name
template <typename Action>
bool with_topic(std::string_view name, Action&& action) {
  bool found = false;
  for_each_topic([&](const auto& sample) {
    if (name != topic<std::decay_t<decltype(sample)>>().name) return;
    found = true;
    action(sample);
  });
  return found;
}

using Sequences = decltype(Tick::newest_seq);  // by Topic::stream

/// Kinds of refused samples that a status lists.
inline int refused_kinds(const ServiceStatus& status) {
  int count = 0;
  while (count < c3rt_v2_REFUSALS && status.refused[count].topic[0] != '\0') ++count;
  return count;
}

}  // namespace c3rt::wire
