#include "idl/faults.hpp"

#include <cmath>

#include "controller/base/time.hpp"
#include "controller/base/words.hpp"

namespace c3rt::wire {
namespace {

using base::words;

bool lasts(c3rt_v2_FaultKind kind) {
  return kind != c3rt_v2_FAULT_NONE && kind != c3rt_v2_FAULT_PUSH_OBJECT;
}

/// Stall, NaN and the end of all are of every process, the others of one.
bool has(Process process, c3rt_v2_FaultKind kind) {
  switch (kind) {
    case c3rt_v2_FAULT_PUSH_OBJECT:
    case c3rt_v2_FAULT_DROP_COMMANDS:
      return process == c3rt_v2_PROCESS_PLANT;
    case c3rt_v2_FAULT_FREEZE_CAMERA:
    case c3rt_v2_FAULT_LOSE_OBJECT:
      return process == c3rt_v2_PROCESS_VISION;
    case c3rt_v2_FAULT_NONE:
    case c3rt_v2_FAULT_STALL:
    case c3rt_v2_FAULT_NAN:
      return process == c3rt_v2_PROCESS_PLANT || process == c3rt_v2_PROCESS_IMPEDANCE ||
             process == c3rt_v2_PROCESS_PLANNER || process == c3rt_v2_PROCESS_VISION;
  }
  return false;
}

std::string refusal_of_push(const FaultInject& fault, const FaultScope& scope) {
  const double* impulse = fault.value;
  const double size = std::hypot(std::hypot(impulse[0], impulse[1]), impulse[2]);
  const int objects = scope.object_masses.empty() ? c3rt_v2_MAX_OBJECTS
                                                  : static_cast<int>(scope.object_masses.size());
  if (fault.index < 0 || fault.index >= objects)
    return words("expected an object from 0 to %d, got %d", objects - 1,
                 static_cast<int>(fault.index));
  if (!std::isfinite(impulse[0]) || !std::isfinite(impulse[1]) || !std::isfinite(impulse[2])) {
    return words("expected an impulse of finite numbers, got (%g, %g, %g) N s", impulse[0],
                 impulse[1], impulse[2]);
  }
  if (scope.object_masses.empty()) return {};
  const double mass = scope.object_masses[static_cast<std::size_t>(fault.index)];
  if (size <= mass * kHardestPush) return {};
  return words(
      "expected an impulse of at most %g N s, which gives object %d of %g kg %g m/s, got %g",
      mass * kHardestPush, static_cast<int>(fault.index), mass, kHardestPush, size);
}

}  // namespace

const char* fault_name(c3rt_v2_FaultKind kind) {
  switch (kind) {
    case c3rt_v2_FAULT_NONE:
      return "none";
    case c3rt_v2_FAULT_PUSH_OBJECT:
      return "push-object";
    case c3rt_v2_FAULT_DROP_COMMANDS:
      return "drop-commands";
    case c3rt_v2_FAULT_FREEZE_CAMERA:
      return "freeze-camera";
    case c3rt_v2_FAULT_LOSE_OBJECT:
      return "lose-object";
    case c3rt_v2_FAULT_STALL:
      return "stall";
    case c3rt_v2_FAULT_NAN:
      return "nan";
  }
  return "?";
}

std::string refusal(const FaultInject& fault, const FaultScope& scope) {
  if (!has(fault.process, fault.kind)) {
    const char* known =
        fault.process == c3rt_v2_PROCESS_PLANT    ? "none, push-object, drop-commands, stall or nan"
        : fault.process == c3rt_v2_PROCESS_VISION ? "none, freeze-camera, lose-object, stall or nan"
                                                  : "none, stall or nan";
    return words("expected %s of %s, got %s (kind %d)", known, process_name(fault.process),
                 fault_name(fault.kind), static_cast<int>(fault.kind));
  }
  if (lasts(fault.kind) && !(fault.duration_s > 0.0 && fault.duration_s <= kLongestFault)) {
    return words("expected a duration of more than 0 and at most %g s, got %g s", kLongestFault,
                 fault.duration_s);
  }
  if (fault.kind == c3rt_v2_FAULT_PUSH_OBJECT) return refusal_of_push(fault, scope);
  if (fault.kind == c3rt_v2_FAULT_FREEZE_CAMERA) {
    if (scope.cameras == 0) return "expected a scenario with cameras, as this one emulates them";
    if (fault.index < 0 || (scope.cameras > 0 && fault.index >= scope.cameras)) {
      return scope.cameras > 0
                 ? words("expected a camera from 0 to %d, got %d", scope.cameras - 1,
                         static_cast<int>(fault.index))
                 : words("expected a camera from 0 on, got %d", static_cast<int>(fault.index));
    }
  }
  return {};
}

std::string describe(const FaultInject& fault) {
  const char* name = fault_name(fault.kind);
  if (fault.kind == c3rt_v2_FAULT_PUSH_OBJECT) {
    return words("%s %d by (%g, %g, %g) N s", name, static_cast<int>(fault.index), fault.value[0],
                 fault.value[1], fault.value[2]);
  }
  if (fault.kind == c3rt_v2_FAULT_FREEZE_CAMERA)
    return words("%s %d for %g s", name, static_cast<int>(fault.index), fault.duration_s);
  if (lasts(fault.kind)) return words("%s for %g s", name, fault.duration_s);
  return fault.kind == c3rt_v2_FAULT_NONE ? "every fault ended" : name;
}

std::int64_t end_of(const FaultInject& fault, std::int64_t now_ns) noexcept {
  return now_ns + base::nanoseconds(fault.duration_s);
}

void FaultWindows::begin(const FaultInject& fault, std::int64_t now_ns) noexcept {
  if (fault.kind == c3rt_v2_FAULT_STALL) stall_until_ns_.store(end_of(fault, now_ns));
  if (fault.kind == c3rt_v2_FAULT_NAN) nan_until_ns_.store(end_of(fault, now_ns));
  if (fault.kind != c3rt_v2_FAULT_NONE) return;
  stall_until_ns_.store(0);
  nan_until_ns_.store(0);
}

}  // namespace c3rt::wire
