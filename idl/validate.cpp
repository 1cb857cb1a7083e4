#include "idl/validate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "controller/base/words.hpp"

namespace c3rt::wire {

namespace {

// what a number of this robot, its table and its objects can be
constexpr double kReach_m = 5.0;  // of the arm, with room
constexpr double kEffectorSpeed_m_per_s = 10.0;
constexpr double kForce_n = 1e3;
constexpr double kJoint_rad = 10.0;
constexpr double kJointSpeed_rad_per_s = 100.0;
constexpr double kTorque_nm = 1e3;
constexpr double kEstimate_n = 1e6;     // near a singular pose a small torque is a large force
constexpr double kObjectSeen_m = 10.0;  // a camera sees no farther
constexpr double kObjectSpeed_m_per_s = 20.0;
constexpr double kObjectSpin_rad_per_s = 2e3;
constexpr double kObjectAcceleration_m_per_s2 = 100.0;
constexpr double kObjectAnywhere_m =
    1e6;  // truth: a table has no end, an object may roll for hours
constexpr double kObjectSpeedAnywhere_m_per_s = 1e4;
constexpr double kObjectSpinAnywhere_rad_per_s = 1e6;
constexpr double kQuaternionTolerance = 1e-2;
constexpr double kPixels = 1e5;
constexpr int kCameras = 64;
constexpr double kLongestPlan_s = 10.0;  // a plan is an answer to what was just seen
constexpr double kLongest_s = 3600.0;    // of a fault, a target's lead time
constexpr double kTargetValue = 1e6;     // of any unit
constexpr double kLargestWeight = 1e12;  // of Algorithm 1
// what a person may order of the robot
constexpr double kLeastThreshold = 0.1, kMostThreshold = 1e3;  // of a collision [N m, N]
constexpr double kHardestPush_n = 200.0;                       // of a hand
constexpr double kLongestPush_s = 60.0;
constexpr double kAnything = std::numeric_limits<double>::max();
constexpr double kLargestSequence = 9007199254740992.0;  // 2^53: 285,000 years at 1 kHz

/// Gathers the first finding of a sample.
class Check {
 public:
  explicit Check(const Header& header) noexcept : time_ns_(header.time_ns) {}

  Check& within(const char* field, double value, double low, double high, int index = -1) noexcept {
    // written so that NaN fails
    if (!found_ && !(value >= low && value <= high)) {
      found_ = {Reason::kValue, field, index, Refusal::Expected::kRange, value, low, high};
      if (high == kAnything) found_.expected = Refusal::Expected::kFinite;
    }
    return *this;
  }
  Check& size(const char* field, double value, double bound, int index = -1) noexcept {
    return within(field, value, -bound, bound, index);
  }
  template <std::size_t n>
  Check& size(const char* field, const double (&values)[n], double bound) noexcept {
    return sizes(field, values, static_cast<int>(n), bound);
  }
  Check& sizes(const char* field, const double* values, int count, double bound) noexcept {
    for (int i = 0; i < count; ++i) size(field, values[i], bound, i);
    return *this;
  }
  Check& finite(const char* field, double value, int index = -1) noexcept {
    return size(field, value, kAnything, index);
  }
  Check& unit(const char* field, const double (&q)[4], int index = -1) noexcept {
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!found_ && !(std::abs(norm - 1.0) <= kQuaternionTolerance))
      found_ = {Reason::kValue, field, index, Refusal::Expected::kUnitNorm, norm, 1.0, 1.0};
    return *this;
  }
  /// All zero: not told.
  Check& unit_or_none(const char* field, const double (&q)[4]) noexcept {
    const bool none = q[0] == 0.0 && q[1] == 0.0 && q[2] == 0.0 && q[3] == 0.0;
    return none ? *this : unit(field, q);
  }
  /// A stamp of what came before this sample; 0 is none.
  Check& stamp(const char* field, std::int64_t stamp_ns) noexcept {
    const bool good = stamp_ns >= 0 && stamp_ns - kAhead_ns <= time_ns_;
    if (!good) within(field, static_cast<double>(stamp_ns) * 1e-9, 0.0, latest(kAhead_ns));
    return *this;
  }
  Check& stamps(const Origin& origin) noexcept {
    return stamp("origin.exposure_ns", origin.exposure_ns)
        .stamp("origin.estimate_ns", origin.estimate_ns)
        .stamp("origin.state_ns", origin.state_ns)
        .stamp("origin.plan_ns", origin.plan_ns);
  }
  // an enumerator or a truth value that is none must not even be read as one
  template <typename E>
  Check& enumerator(const char* field, const E& value, int index) noexcept {
    static_assert(sizeof(E) == sizeof(std::uint32_t));
    constexpr std::uint32_t kLast = enumerators(E{}) - 1;
    std::uint32_t raw = 0;
    std::memcpy(&raw, &value, sizeof raw);
    if (!found_ && raw > kLast)
      found_ = {Reason::kValue,
                field,
                index,
                Refusal::Expected::kEnumerator,
                static_cast<double>(raw),
                0.0,
                static_cast<double>(kLast)};
    return *this;
  }
  Check& truth(const char* field, const bool& value, int index) noexcept {
    std::uint8_t raw = 0;
    std::memcpy(&raw, &value, sizeof raw);
    return within(field, raw, 0.0, 1.0, index);
  }
  /// A text that ends and says nothing to a terminal but letters.
  template <std::size_t n>
  Check& text(const char* field, const char (&value)[n], int index = -1) noexcept {
    const void* end = std::memchr(value, '\0', n);
    const auto length =
        end == nullptr ? n : static_cast<std::size_t>(static_cast<const char*>(end) - value);
    const bool printable = std::none_of(value, value + length, [](char letter) {
      return static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f;
    });
    if (!found_ && (end == nullptr || !printable))
      found_ = {Reason::kValue,
                field,
                index,
                Refusal::Expected::kText,
                static_cast<double>(length),
                0.0,
                static_cast<double>(n - 1)};
    return *this;
  }
  double latest(std::int64_t ahead_ns) const noexcept {
    return (static_cast<double>(time_ns_) + static_cast<double>(ahead_ns)) * 1e-9;
  }
  Refusal finding() const noexcept { return found_; }

 private:
  std::int64_t time_ns_;
  Refusal found_;
};

std::string number(double value) {
  const bool whole = std::abs(value) < 1e15 && value == std::floor(value);
  return base::words(whole ? "%.0f" : "%.6g", value);
}

}  // namespace

const char* reason_name(Reason reason) {
  switch (reason) {
    case Reason::kNone:
      return "none";
    case Reason::kValue:
      return "value";
    case Reason::kHeader:
      return "header";
    case Reason::kSecondWriter:
      return "second writer";
    case Reason::kOtherSession:
      return "other session";
    case Reason::kOldSequence:
      return "old sequence";
  }
  return "unknown";
}

std::string to_text(const Refusal& refusal) {
  std::string field = refusal.field;
  if (refusal.index >= 0) field += "[" + std::to_string(refusal.index) + "]";
  const std::string range = refusal.low == refusal.high
                                ? number(refusal.low)
                                : number(refusal.low) + " to " + number(refusal.high);
  switch (refusal.reason) {
    case Reason::kNone:
      return "";
    case Reason::kValue:
    case Reason::kHeader:
      break;
    case Reason::kSecondWriter:
      return "its topic has one writer, another one";
    case Reason::kOtherSession:
      return "not of the session of the plant";
    case Reason::kOldSequence:
      return "its writer has sent this sequence number or a later one before";
  }
  switch (refusal.expected) {
    case Refusal::Expected::kRange:
      return field + " is " + number(refusal.came) + ", expected " + range;
    case Refusal::Expected::kFinite:
      return field + " is " + number(refusal.came) + ", expected a finite number";
    case Refusal::Expected::kUnitNorm:
      return (refusal.came == 0.0 ? "zero quaternion " : "quaternion ") + field + ": norm " +
             number(refusal.came) + ", expected 1";
    case Refusal::Expected::kEnumerator:
      return field + " is " + number(refusal.came) + ", expected an enumerator, " + range;
    case Refusal::Expected::kText:
      return field + " is no text: expected at most " + number(refusal.high) +
             " printable letters and an end";
  }
  return "";
}

Refusal validate(const Header& header, bool one_writer, std::int64_t latest_ns) noexcept {
  Refusal refusal{Reason::kHeader};
  if (header.seq < 1 || static_cast<double>(header.seq) > kLargestSequence) {
    refusal.field = "header.seq";
    refusal.came = static_cast<double>(header.seq);
    refusal.low = 1.0;
    refusal.high = kLargestSequence;
    return refusal;
  }
  if (!one_writer || (header.time_ns >= 0 && header.time_ns <= latest_ns)) return {};
  refusal.field = "header.time_ns in seconds";
  refusal.came = static_cast<double>(header.time_ns) * 1e-9;
  refusal.low = 0.0;
  refusal.high = static_cast<double>(latest_ns) * 1e-9;
  return refusal;
}

namespace {

/// The rules of form, which hold for every type.
class Form {
 public:
  explicit Form(Check& check) noexcept : check_(check) {}

  template <typename T>
  void operator()(const char* name, const T& value) noexcept {
    look(name, value, -1);
  }
  void machine_time(const char* name, double value) noexcept { look(name, value, -1); }
  /// The first `count` of an array.
  template <typename T, std::size_t n>
  void list(const char* name, const T (&values)[n], int count) noexcept {
    check_.within(name, count, 0, static_cast<double>(n));
    for (int i = 0; i < count && !check_.finding(); ++i) look(name, values[i], i);
  }

 private:
  template <typename T>
  void look(const char* name, const T& value, int index) noexcept {
    if constexpr (std::is_same_v<T, Header>) {
      // validate(const Header&) has looked
    } else if constexpr (std::is_array_v<T>) {
      if constexpr (std::is_same_v<std::remove_extent_t<T>, char>) {
        check_.text(name, value, index);
      } else {
        int i = 0;
        for (const auto& element : value) look(name, element, i++);
      }
    } else if constexpr (std::is_enum_v<T>) {
      check_.enumerator(name, value, index);
    } else if constexpr (std::is_same_v<T, bool>) {
      check_.truth(name, value, index);
    } else if constexpr (std::is_floating_point_v<T>) {
      check_.finite(name, value, index);
    } else if constexpr (std::is_class_v<T>) {
      visit_fields(value, *this);
    }
  }
  Check& check_;
};

template <typename T>
void check_ranges(const T&, Check&) noexcept {}  // nothing beyond the form

void check_ranges(const RobotState& s, Check& check) noexcept {
  check.within("robot", s.robot, 0, 0)
      .size("q_rad", s.q_rad, kJoint_rad)
      .size("dq_rad_per_s", s.dq_rad_per_s, kJointSpeed_rad_per_s)
      .size("tau_nm", s.tau_nm, kTorque_nm)
      .size("p_WE_m", s.p_WE_m, kReach_m)
      .unit_or_none("q_WE", s.q_WE)
      .within("command_success_rate", s.command_success_rate, 0.0, 1.0)
      .stamp("command_state_ns", s.command_state_ns);
}

void check_ranges(const RobotContact& s, Check& check) noexcept {
  check.within("robot", s.robot, 0, 0)
      .size("tau_external_nm", s.tau_external_nm, kEstimate_n)
      .size("force_W_n", s.force_W_n, kEstimate_n)
      .size("torque_W_nm", s.torque_W_nm, kEstimate_n)
      .size("force_E_n", s.force_E_n, kEstimate_n)
      .size("torque_E_nm", s.torque_E_nm, kEstimate_n)
      .within("error", s.error, -1, 63)
      .within("axis", s.axis, 0, 7);
}

void check_ranges(const RobotCommand& s, Check& check) noexcept {
  check.within("robot", s.robot, 0, 0)
      .stamps(s.origin)
      .size("tau_nm", s.tau_nm, kTorque_nm)
      .size("p_WE_desired_m", s.p_WE_desired_m, kReach_m)
      .size("v_WE_desired_m_per_s", s.v_WE_desired_m_per_s, kEffectorSpeed_m_per_s);
}

void check_ranges(const RobotMotion& s, Check& check) noexcept {
  check.within("robot", s.robot, 0, 0)
      .stamps(s.origin)
      .size("q_rad", s.q_rad, kJoint_rad)
      .size("dq_rad_per_s", s.dq_rad_per_s, kJointSpeed_rad_per_s)
      .size("p_WE_m", s.p_WE_m, kReach_m)
      .size("v_WE_m_per_s", s.v_WE_m_per_s, kEffectorSpeed_m_per_s)
      .size("omega_WE_rad_per_s", s.omega_WE_rad_per_s, kJointSpeed_rad_per_s)
      .size("elbow_q3_rad", s.elbow_q3_rad, kJoint_rad)
      .size("elbow_sign", s.elbow_sign, 1.0)
      .truth("has_elbow", s.has_elbow, -1)
      .enumerator("kind", s.kind, -1);
  if (check.finding()) return;
  if (s.has_elbow) check.within("|elbow_sign|", std::abs(s.elbow_sign), 1.0, 1.0);
  if (s.kind == c3rt_v2_MOTION_CARTESIAN_POSE) {
    check.unit("q_WE", s.q_WE);
  } else {
    check.unit_or_none("q_WE", s.q_WE);
  }
}

/// Names of the fields of one of an order's two phases.
struct ThresholdNames {
  const char *contact_torque, *collision_torque, *contact_force, *collision_force,
      *contact_torque_E, *collision_torque_E;
};
constexpr ThresholdNames kAccelerationNames{
    "acceleration.contact_torque_nm",   "acceleration.collision_torque_nm",
    "acceleration.contact_force_E_n",   "acceleration.collision_force_E_n",
    "acceleration.contact_torque_E_nm", "acceleration.collision_torque_E_nm"};
constexpr ThresholdNames kNominalNames{
    "nominal.contact_torque_nm",   "nominal.collision_torque_nm", "nominal.contact_force_E_n",
    "nominal.collision_force_E_n", "nominal.contact_torque_E_nm", "nominal.collision_torque_E_nm"};

/// A contact is told no later than the collision that it becomes.
template <std::size_t n>
void check_pair(Check& check, const char* contact_name, const double (&contact)[n],
                const char* collision_name, const double (&collision)[n]) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    check.within(collision_name, collision[i], kLeastThreshold, kMostThreshold, static_cast<int>(i))
        .within(contact_name, contact[i], 0.0, collision[i], static_cast<int>(i));
  }
}

void check_thresholds(Check& check, const c3rt_v2_ContactThresholds& s,
                      const ThresholdNames& names) noexcept {
  check_pair(check, names.contact_torque, s.contact_torque_nm, names.collision_torque,
             s.collision_torque_nm);
  check_pair(check, names.contact_force, s.contact_force_E_n, names.collision_force,
             s.collision_force_E_n);
  check_pair(check, names.contact_torque_E, s.contact_torque_E_nm, names.collision_torque_E,
             s.collision_torque_E_nm);
}

void check_ranges(const RobotOrder& s, Check& check) noexcept {
  check.within("robot", s.robot, 0, 0)
      .enumerator("kind", s.kind, -1)
      .truth("engaged", s.engaged, -1)
      .truth("free_elbow", s.free_elbow, -1);
  if (check.finding()) return;
  // a hand that may lead the arm nowhere is a mistake
  const bool guided = s.kind == c3rt_v2_ORDER_GUIDING && s.engaged && !s.free_elbow;
  const bool push = s.kind == c3rt_v2_ORDER_PUSH;
  check.within("free_axes", s.free_axes, guided ? 1 : 0, 63)
      .size("force_W_n", s.force_W_n, kHardestPush_n)
      .within("duration_s", s.duration_s, push ? 1e-3 : 0.0, kLongestPush_s);
  if (s.kind != c3rt_v2_ORDER_THRESHOLDS) return;
  check_thresholds(check, s.acceleration, kAccelerationNames);
  check_thresholds(check, s.nominal, kNominalNames);
}

void check_ranges(const Plan& s, Check& check) noexcept {
  const auto after_time = [&s](std::int64_t time_ns) {
    return (static_cast<double>(time_ns) - static_cast<double>(s.header.time_ns)) * 1e-9;
  };
  check.within("robot", s.robot, 0, 0)
      .stamps(s.origin)
      .within("valid_until_ns after time_ns in seconds", after_time(s.valid_until_ns), 0.0,
              kLongestPlan_s)
      .within("solve_time_s", s.solve_time_s, 0.0, kLongest_s)
      .within("knot_count", s.knot_count, 1, c3rt_v2_MAX_KNOTS);
  const int knots = check.finding() ? 0 : static_cast<int>(s.knot_count);
  for (int i = 0; i < knots; ++i) {
    const c3rt_v2_Knot& knot = s.knots[i];
    check
        .size("knots.time_ns after time_ns in seconds", after_time(knot.time_ns), kLongestPlan_s, i)
        .size("knots.p_WE_m", knot.p_WE_m, kReach_m)
        .size("knots.v_WE_m_per_s", knot.v_WE_m_per_s, kEffectorSpeed_m_per_s)
        .unit("knots.q_WE", knot.q_WE, i)
        .size("knots.force_E_n", knot.force_E_n, kForce_n);
    if (i > 0 && !check.finding()) {
      check.within("knots.time_ns after the knot before in seconds",
                   static_cast<double>(knot.time_ns - s.knots[i - 1].time_ns) * 1e-9, 1e-9,
                   kLongestPlan_s, i);
    }
  }
}

void check_ranges(const PlannerDebug& s, Check& check) noexcept {
  check.within("robot", s.robot, 0, 0)
      .within("object_index", s.object_index, 0, c3rt_v2_MAX_OBJECTS - 1)
      .within("horizon", s.horizon, 0, c3rt_v2_MAX_HORIZON)
      .within("state_count", s.state_count, 0, c3rt_v2_MAX_STATES)
      .within("force_count", s.force_count, 0, c3rt_v2_MAX_FORCES)
      .within("input_count", s.input_count, 0, c3rt_v2_MAX_INPUTS)
      .within("admm_iterations", s.admm_iterations, 0, c3rt_v2_MAX_ADMM);
}

void check_ranges(const ObjectDetection& s, Check& check) noexcept {
  check.within("camera", s.camera, 0, kCameras - 1)
      .within("object_index", s.object_index, 0, c3rt_v2_MAX_OBJECTS - 1)
      .stamp("exposure_ns", s.exposure_ns)
      .size("u_px", s.u_px, kPixels)
      .size("v_px", s.v_px, kPixels)
      .within("radius_px", s.radius_px, 0.0, kPixels)
      .size("p_WB_m", s.p_WB_m, kObjectSeen_m)
      .unit_or_none("q_WB", s.q_WB);
}

void check_ranges(const ObjectEstimate& s, Check& check) noexcept {
  check.within("object_index", s.object_index, 0, c3rt_v2_MAX_OBJECTS - 1)
      .stamp("exposure_ns", s.exposure_ns)
      .within("sensors_used", s.sensors_used, 0, kCameras)
      .size("p_measured_m", s.p_measured_m, kObjectSeen_m)
      .unit_or_none("q_measured", s.q_measured)
      .size("p_WB_m", s.p_WB_m, kObjectSeen_m)
      .unit("q_WB", s.q_WB)
      .size("v_WB_m_per_s", s.v_WB_m_per_s, kObjectSpeed_m_per_s)
      .size("omega_rad_per_s", s.omega_rad_per_s, kObjectSpin_rad_per_s)
      .size("a_WB_m_per_s2", s.a_WB_m_per_s2, kObjectAcceleration_m_per_s2);
}

// what this robot can reach is the planner's to say; here is what no planner could do
void check_ranges(const TaskTarget& s, Check& check) noexcept {
  check.within("parameter_count", s.parameter_count, 0, c3rt_v2_MAX_TARGET_PARAMETERS);
  const int parameters = check.finding() ? 0 : static_cast<int>(s.parameter_count);
  for (int i = 0; i < parameters; ++i) {
    const c3rt_v2_TargetParameter& parameter = s.parameters[i];
    check.within("parameters.value_count", parameter.value_count, 0, c3rt_v2_MAX_TARGET_VALUES, i)
        .size("parameters.values", parameter.values, kTargetValue);
  }
}

void check_ranges(const PlannerWeights& s, Check& check) noexcept {
  check.within("weight_count", s.weight_count, 0, c3rt_v2_MAX_WEIGHTS);
  const int weights = check.finding() ? 0 : static_cast<int>(s.weight_count);
  for (int i = 0; i < weights; ++i)
    check.within("weights.value", s.weights[i].value, 0.0, kLargestWeight, i);
}

void check_ranges(const Scene& s, Check& check) noexcept {
  check.size("q_rad", s.q_rad, kJoint_rad)
      .size("p_WE_m", s.p_WE_m, kReach_m)
      .within("object_count", s.object_count, 0, c3rt_v2_MAX_OBJECTS);
  const int objects = check.finding() ? 0 : static_cast<int>(s.object_count);
  for (int i = 0; i < objects; ++i) {
    const c3rt_v2_SceneObject& object = s.objects[i];
    check.size("objects.p_WB_m", object.p_WB_m, kObjectAnywhere_m)
        .unit("objects.q_WB", object.q_WB, i)
        .size("objects.v_WB_m_per_s", object.v_WB_m_per_s, kObjectSpeedAnywhere_m_per_s)
        .size("objects.omega_rad_per_s", object.omega_rad_per_s, kObjectSpinAnywhere_rad_per_s);
  }
}

void check_ranges(const ServiceStatus& s, Check& check) noexcept {
  check.within("rate_hz", s.rate_hz, 0.0, kAnything);
}

void check_ranges(const FaultInject& s, Check& check) noexcept {
  check.within("duration_s", s.duration_s, 0.0, kLongest_s).size("value", s.value, kForce_n);
}

}  // namespace

#define C3RT_TOPIC(Type, ...)                     \
  Refusal validate(const Type& sample) noexcept { \
    Check check(sample.header);                   \
    check_ranges(sample, check);                  \
    Form form(check);                             \
    visit_fields(sample, form);                   \
    return check.finding();                       \
  }
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

}  // namespace c3rt::wire
