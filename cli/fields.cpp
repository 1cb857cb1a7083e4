#include "cli/fields.hpp"

#include "idl/faults.hpp"

namespace c3rt::cli {

const char* name_of(c3rt_v1_RobotMode value) {
  switch (value) {
    case c3rt_v1_ROBOT_IDLE:
      return "idle";
    case c3rt_v1_ROBOT_MOVE:
      return "move";
    case c3rt_v1_ROBOT_REFLEX:
      return "reflex";
    case c3rt_v1_ROBOT_USER_STOPPED:
      return "user stopped";
  }
  return "?";
}

const char* name_of(c3rt_v1_ImpedanceMode value) {
  switch (value) {
    case c3rt_v1_IMPEDANCE_WAIT:
      return "wait";
    case c3rt_v1_IMPEDANCE_HOLD:
      return "hold";
    case c3rt_v1_IMPEDANCE_TRACK:
      return "track";
    case c3rt_v1_IMPEDANCE_STOP:
      return "stop";
  }
  return "?";
}

const char* name_of(c3rt_v1_PlanStatus value) {
  switch (value) {
    case c3rt_v1_PLAN_OK:
      return "ok";
    case c3rt_v1_PLAN_TRUNCATED:
      return "truncated";
    case c3rt_v1_PLAN_FALLBACK:
      return "fallback";
  }
  return "?";
}

const char* name_of(c3rt_v1_PlanPhase value) {
  switch (value) {
    case c3rt_v1_PHASE_WAIT:
      return "wait";
    case c3rt_v1_PHASE_APPROACH:
      return "approach";
    case c3rt_v1_PHASE_ROLL:
      return "roll";
    case c3rt_v1_PHASE_RETURN:
      return "return";
    case c3rt_v1_PHASE_HOLD:
      return "hold";
  }
  return "?";
}

const char* name_of(c3rt_v1_TargetKind value) {
  switch (value) {
    case c3rt_v1_TARGET_SCENARIO:
      return "scenario";
    case c3rt_v1_TARGET_HOLD:
      return "hold";
    case c3rt_v1_TARGET_CIRCLE:
      return "circle";
    case c3rt_v1_TARGET_POINT:
      return "point";
  }
  return "?";
}

const char* name_of(c3rt_v1_ServiceState value) {
  switch (value) {
    case c3rt_v1_SERVICE_STARTING:
      return "starting";
    case c3rt_v1_SERVICE_RUNNING:
      return "running";
    case c3rt_v1_SERVICE_DEGRADED:
      return "degraded";
    case c3rt_v1_SERVICE_FAILED:
      return "failed";
    case c3rt_v1_SERVICE_STOPPING:
      return "stopping";
  }
  return "?";
}

const char* name_of(c3rt_v1_RequestVerb value) {
  switch (value) {
    case c3rt_v1_REQUEST_RECOVER:
      return "recover";
    case c3rt_v1_REQUEST_STOP:
      return "stop";
    case c3rt_v1_REQUEST_SHUTDOWN:
      return "shutdown";
  }
  return "?";
}

const char* name_of(c3rt_v1_FaultKind value) { return wire::fault_name(value); }

}  // namespace c3rt::cli
