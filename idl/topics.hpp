#pragma once
// Every topic in one table. A new topic is a struct in c3rt.idl and a line here (and its ranges in
// validate.cpp, where it has some): its type, what readers and writers do with it, echo, hz,
// topics, recorder, the permissions of a secure bus and the tests follow from them.
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
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
  kReport,  // as kStream, but nobody waits for it, and no log has it
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
  kOptional,   // few runs have it: the log's hash of the others has no trace of it
};

/// Who takes part, each under an identity of its own where the bus is secure; a set of them.
using Parties = unsigned;
namespace party {
constexpr Parties of(Process process) { return 1U << process; }
constexpr Parties kPlant = of(c3rt_v2_PROCESS_PLANT);
constexpr Parties kImpedance = of(c3rt_v2_PROCESS_IMPEDANCE);
constexpr Parties kPlanner = of(c3rt_v2_PROCESS_PLANNER);
constexpr Parties kVision = of(c3rt_v2_PROCESS_VISION);
// commands of a person, the recorder, programs of others
constexpr Parties kClients = of(c3rt_v2_PROCESS_RECORDER);
constexpr Parties kProcesses = kPlant | kImpedance | kPlanner | kVision;
constexpr Parties kAll = kProcesses | kClients;
}  // namespace party

constexpr int kNoStream = -1;

struct Topic {
  const char* name;
  const dds_topic_descriptor_t* descriptor;
  Qos qos;
  Parties writers, readers;
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

// clang-format off
//      type,            name,               quality, writers,    readers,                      deadline, trait        // rate
#define C3RT_TOPICS(TOPIC)                                                                                                                    \
  TOPIC(Scene,           "sim/scene",        kStream, kPlant,     kVision | kClients,           0.0,      kNone)      /* at exposures, >= 100 Hz */\
  TOPIC(RobotState,      "robot/state",      kStream, kPlant,     kAll,                         0.02,     kNone)      /* 1 kHz */             \
  TOPIC(RobotContact,    "robot/contact",    kReport, kPlant,     kClients,                     0.0,      kNone)      /* 100 Hz, changes */   \
  TOPIC(RobotCommand,    "robot/command",    kStream, kImpedance, kPlant | kPlanner | kClients, 0.02,     kNone)      /* 1 kHz */             \
  TOPIC(Plan,            "plan",             kPlan,   kPlanner,   kImpedance | kClients,        0.0,      kNone)      /* fixed rate */        \
  TOPIC(ObjectEstimate,  "object/estimate",  kStream, kVision,    kPlanner | kClients,          0.1,      kNone)      /* >= 80 Hz */          \
  TOPIC(ObjectDetection, "object/detection", kStream, kVision,    kClients,                     0.0,      kNone)      /* camera rate */       \
  TOPIC(PlannerDebug,    "planner/debug",    kStream, kPlanner,   kClients,                     0.0,      kNone)      /* as plan */           \
  TOPIC(RobotMotion,     "robot/motion",     kStream, kImpedance, kPlant | kClients,            0.0,      kOptional)  /* 1 kHz */             \
  TOPIC(TaskTarget,      "task/target",      kEvent,  kClients,   kPlanner | kClients,          0.0,      kAnswered)  /* on change */         \
  TOPIC(Tick,            "sim/tick",         kSync,   kPlant,     kAll,                         0.0,      kAddressed) /* lockstep */          \
  TOPIC(Done,            "sim/done",         kSync,   kAll,       kPlant | kClients,            0.0,      kNone)      /* lockstep */          \
  TOPIC(ServiceStatus,   "service/status",   kStatus, kProcesses, kClients,                     0.0,      kNone)      /* 10 Hz */             \
  TOPIC(ServiceRequest,  "service/request",  kEvent,  kClients,   kAll,                         0.0,      kAnswered)  /* on demand */         \
  TOPIC(ServiceReply,    "service/reply",    kEvent,  kAll,       kClients,                     0.0,      kNone)      /* on demand */         \
  TOPIC(FaultInject,     "fault/inject",     kEvent,  kClients,   kAll,                         0.0,      kAnswered)  /* on demand */         \
  TOPIC(RobotOrder,      "robot/order",      kEvent,  kClients,   kPlant | kClients,            0.0,      kAnswered)  /* on demand */         \
  TOPIC(PlannerWeights,  "planner/weights",  kEvent,  kClients,   kPlanner | kClients,          0.0,      kAnswered)  /* on demand */
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

/// The process, if there is no other party.
constexpr std::optional<Process> only_process(Parties parties) {
  for (const Process process : {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE,
                                c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION}) {
    if (parties == party::of(process)) return process;
  }
  return std::nullopt;
}

constexpr std::array<Topic, kCount> make() {
  using namespace party;
  std::array<Topic, kCount> topics = {{
#define C3RT_TOPIC(Type, name, quality, writers, readers, deadline, trait) \
  Topic{name,    &c3rt_v2_##Type##_desc, Qos::quality, writers,            \
        readers, only_process(writers),  deadline,     Trait::trait},
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

/// Whether a request says whom it is for; one that does not is for the only process that reads it.
template <typename T, typename = void>
inline constexpr bool kNamesProcess = false;
template <typename T>
inline constexpr bool kNamesProcess<T, std::void_t<decltype(T::process)>> = true;

/// Who is to answer a request that was let in.
template <typename T>
Process asked_process(const T& request) {
  static_assert(topic<T>().trait == Trait::kAnswered);
  if constexpr (kNamesProcess<T>) {
    return request.process;
  } else {
    constexpr auto kReader = table::only_process(topic<T>().readers & ~party::kClients);
    static_assert(kReader.has_value(), "it names its process, or one alone reads it");
    return *kReader;
  }
}

using Sequences = decltype(Tick::newest_seq);  // by Topic::stream

/// Kinds of refused samples that a status lists.
inline int refused_kinds(const ServiceStatus& status) {
  int count = 0;
  while (count < c3rt_v2_REFUSALS && status.refused[count].topic[0] != '\0') ++count;
  return count;
}

}  // namespace c3rt::wire
