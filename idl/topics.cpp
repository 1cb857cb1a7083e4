#include "idl/topics.hpp"

#include <type_traits>

namespace c3rt::wire {

static_assert(c3rt_v1_PROCESS_RECORDER + 1 == kProcessCount, "a name for every process");
static_assert(static_cast<int>(Stream::kScene) < c3rt_v1_TOPIC_COUNT,
              "a tick has room for every stream");
// fixed size: a sample is copied as bytes between threads and taken without allocation
static_assert(std::is_trivially_copyable_v<Plan> && std::is_trivially_copyable_v<ServiceStatus>);

const char* process_name(Process process) {
  switch (process) {
    case c3rt_v1_PROCESS_PLANT:
      return "plant";
    case c3rt_v1_PROCESS_IMPEDANCE:
      return "impedance";
    case c3rt_v1_PROCESS_PLANNER:
      return "planner";
    case c3rt_v1_PROCESS_VISION:
      return "vision";
    case c3rt_v1_PROCESS_RECORDER:
      return "recorder";
  }
  return "unknown process";
}

namespace {

constexpr std::nullopt_t kMany = std::nullopt;  // clients, or every process
// clang-format off
constexpr Topic kRobotState    {"robot/state",     &c3rt_v1_RobotState_desc,     Qos::kStream, Stream::kRobotState,    c3rt_v1_PROCESS_PLANT,     0.02};
constexpr Topic kRobotCommand  {"robot/command",   &c3rt_v1_RobotCommand_desc,   Qos::kStream, Stream::kRobotCommand,  c3rt_v1_PROCESS_IMPEDANCE, 0.02};
constexpr Topic kPlan          {"plan",            &c3rt_v1_Plan_desc,           Qos::kPlan,   Stream::kPlan,          c3rt_v1_PROCESS_PLANNER,   0.0};
constexpr Topic kBallDetection {"ball/detection",  &c3rt_v1_BallDetection_desc,  Qos::kStream, Stream::kBallDetection, c3rt_v1_PROCESS_VISION,    0.0};
constexpr Topic kBallEstimate  {"ball/estimate",   &c3rt_v1_BallEstimate_desc,   Qos::kStream, Stream::kBallEstimate,  c3rt_v1_PROCESS_VISION,    0.1};
constexpr Topic kTaskTarget    {"task/target",     &c3rt_v2_TaskTarget_desc,     Qos::kEvent,  Stream::kNone,          kMany,                     0.0};
constexpr Topic kScene         {"sim/scene",       &c3rt_v1_Scene_desc,          Qos::kStream, Stream::kScene,         c3rt_v1_PROCESS_PLANT,     0.0};
constexpr Topic kTick          {"sim/tick",        &c3rt_v1_Tick_desc,           Qos::kSync,   Stream::kNone,          c3rt_v1_PROCESS_PLANT,     0.0, true};
constexpr Topic kDone          {"sim/done",        &c3rt_v1_Done_desc,           Qos::kSync,   Stream::kNone,          kMany,                     0.0};
constexpr Topic kServiceStatus {"service/status",  &c3rt_v2_ServiceStatus_desc,  Qos::kStatus, Stream::kNone,          kMany,                     0.0};
constexpr Topic kServiceRequest{"service/request", &c3rt_v1_ServiceRequest_desc, Qos::kEvent,  Stream::kNone,          kMany,                     0.0};
constexpr Topic kServiceReply  {"service/reply",   &c3rt_v2_ServiceReply_desc,   Qos::kEvent,  Stream::kNone,          kMany,                     0.0};
constexpr Topic kFaultInject   {"fault/inject",    &c3rt_v2_FaultInject_desc,    Qos::kEvent,  Stream::kNone,          kMany,                     0.0};
// clang-format on

}  // namespace

// clang-format off
template <> const Topic& topic<RobotState>()     { return kRobotState; }
template <> const Topic& topic<RobotCommand>()   { return kRobotCommand; }
template <> const Topic& topic<Plan>()           { return kPlan; }
template <> const Topic& topic<BallDetection>()  { return kBallDetection; }
template <> const Topic& topic<BallEstimate>()   { return kBallEstimate; }
template <> const Topic& topic<TaskTarget>()     { return kTaskTarget; }
template <> const Topic& topic<Scene>()          { return kScene; }
template <> const Topic& topic<Tick>()           { return kTick; }
template <> const Topic& topic<Done>()           { return kDone; }
template <> const Topic& topic<ServiceStatus>()  { return kServiceStatus; }
template <> const Topic& topic<ServiceRequest>() { return kServiceRequest; }
template <> const Topic& topic<ServiceReply>()   { return kServiceReply; }
template <> const Topic& topic<FaultInject>()    { return kFaultInject; }
// clang-format on

}  // namespace c3rt::wire
