#pragma once
// Every topic in one table: type, name, quality of service, writer and readers, rate.
#include <cstdint>
#include <optional>
#include <string_view>

#include "c3rt.h"  // generated from idl/c3rt.idl

namespace c3rt::wire {

using Header = c3rt_v1_Header;
using Origin = c3rt_v1_Origin;
using RobotState = c3rt_v1_RobotState;
using RobotCommand = c3rt_v1_RobotCommand;
using Plan = c3rt_v1_Plan;
using BallDetection = c3rt_v1_BallDetection;
using BallEstimate = c3rt_v1_BallEstimate;
using TaskTarget = c3rt_v2_TaskTarget;
using Scene = c3rt_v1_Scene;
using Tick = c3rt_v1_Tick;
using Done = c3rt_v1_Done;
using Quantiles = c3rt_v1_Quantiles;
using RefusedSamples = c3rt_v2_RefusedSamples;
using ServiceStatus = c3rt_v2_ServiceStatus;
using ServiceRequest = c3rt_v1_ServiceRequest;
using ServiceReply = c3rt_v2_ServiceReply;
using FaultInject = c3rt_v2_FaultInject;
using Process = c3rt_v1_Process;

using Sequences = decltype(c3rt_v1_Tick::newest_seq);  // by Stream

/// Kinds of refused samples that a status lists.
inline int refused_kinds(const ServiceStatus& status) {
  int count = 0;
  while (count < c3rt_v2_REFUSALS && status.refused[count].topic[0] != '\0') ++count;
  return count;
}

constexpr int kProcessCount = 5;
const char* process_name(Process process);  // "plant", "impedance", "planner", "vision", "recorder"

/// How a topic behaves on the network; the numbers stand in qos.cpp, once.
enum class Qos {
  kStream,  // best effort, keep last 1; in lockstep reliable, so that no sample can be lost
  kPlan,    // reliable, keep last 1, liveliness
  kEvent,   // reliable, transient local, keep last 16
  kStatus,  // reliable, transient local, keep last 1, liveliness
  kSync,    // reliable, keep last 256: lockstep only
};

/// Streams whose newest sequence number a Tick carries (index into Tick.newest_seq); -1: not in a
/// tick.
enum class Stream : int {
  kNone = -1,
  kRobotState = 0,
  kRobotCommand = 1,
  kPlan = 2,
  kBallEstimate = 3,
  kBallDetection = 4,
  kScene = 5,
};

struct Topic {
  const char* name;
  const dds_topic_descriptor_t* descriptor;
  Qos qos;
  Stream stream;
  /// The one process that writes it, where there must be only one: what moves the robot and what
  /// that is made from. A reader obeys one writer (one_writer.hpp), in the plant's session alone;
  /// others are refused and named.
  std::optional<Process> writer;
  double deadline_s;  // 0: none. Requested and offered where the topic is periodic (realtime only).
  /// Each sample is for one process: writers and readers may name it, and then it costs nobody else
  /// anything. Who names no process writes to and reads of all.
  bool addressed = false;
};

template <typename T>
const Topic& topic();  // specialised for each type below, in topics.cpp

// clang-format off
template <> const Topic& topic<RobotState>();      // robot/state      plant -> all              1 kHz
template <> const Topic& topic<RobotCommand>();    // robot/command    impedance -> plant        1 kHz
template <> const Topic& topic<Plan>();            // plan             planner -> impedance      75 Hz
template <> const Topic& topic<BallDetection>();   // ball/detection   vision -> clients         camera rate
template <> const Topic& topic<BallEstimate>();    // ball/estimate    vision -> planner         >= 80 Hz
template <> const Topic& topic<TaskTarget>();      // task/target      clients -> planner        on change
template <> const Topic& topic<Scene>();           // sim/scene        plant -> vision, recorder >= 100 Hz
template <> const Topic& topic<Tick>();            // sim/tick         plant -> all              lockstep
template <> const Topic& topic<Done>();            // sim/done         all -> plant              lockstep
template <> const Topic& topic<ServiceStatus>();   // service/status   all -> clients            10 Hz
template <> const Topic& topic<ServiceRequest>();  // service/request  clients -> all            on demand
template <> const Topic& topic<ServiceReply>();    // service/reply    all -> clients            on demand
template <> const Topic& topic<FaultInject>();     // fault/inject     clients -> all            on demand
// clang-format on

}  // namespace c3rt::wire
