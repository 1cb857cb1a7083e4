#pragma once
// Between the wire's types and those of the rooms: vectors, rotations, bodies, estimates, tasks,
// plans, states and modes. The one place where that is written. It includes no room but the scene's
// and the task's: what it takes of another one is a template's parameter.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>

#include <Eigen/Geometry>

#include "controller/scene/scene.hpp"
#include "controller/task/request.hpp"
#include "idl/text.hpp"
#include "idl/topics.hpp"

namespace c3rt::wire {

static_assert(c3rt_v2_MAX_OBJECTS == scene::kMaxBodies,
              "the wire has room for every body of a scene");

// all of motion RT: no heap, no lock, no throw

template <std::size_t n>
Eigen::Matrix<double, static_cast<int>(n), 1> vector(const double (&values)[n]) noexcept {
  return Eigen::Map<const Eigen::Matrix<double, static_cast<int>(n), 1>>(values);
}

/// On the wire a quaternion is w, x, y, z.
inline Eigen::Quaterniond quaternion(const double (&wxyz)[4]) noexcept {
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

/// As many as both have; the rest stays.
template <std::size_t n, typename Derived>
void fill(double (&out)[n], const Eigen::MatrixBase<Derived>& values) noexcept {
  const auto count = std::min<Eigen::Index>(static_cast<Eigen::Index>(n), values.size());
  for (Eigen::Index i = 0; i < count; ++i) out[i] = values[i];
}

template <int options>
void fill(double (&wxyz)[4], const Eigen::Quaternion<double, options>& q) noexcept {
  wxyz[0] = q.w();
  wxyz[1] = q.x();
  wxyz[2] = q.y();
  wxyz[3] = q.z();
}

/// Where it is and how it moves, of anything that says so on the wire: an object of the scene, an
/// estimate.
template <typename Sample, typename Body>
void fill_motion(Sample& out, const Body& body) noexcept {
  fill(out.p_WB_m, body.p_WB);
  fill(out.q_WB, body.q_WB);
  fill(out.v_WB_m_per_s, body.v_WB);
  fill(out.omega_rad_per_s, body.omega_WB);
}

/// The same the other way; what a sample does not say is as it is by default.
template <typename Sample>
scene::Body body(const Sample& sample) noexcept {
  scene::Body body;
  body.p_WB = vector(sample.p_WB_m);
  body.q_WB = quaternion(sample.q_WB);
  body.v_WB = vector(sample.v_WB_m_per_s);
  body.omega_WB = vector(sample.omega_rad_per_s);
  return body;
}

/// What was measured of an object, and what its filter makes of it.
template <typename Measurement, typename Filtered>
void fill_estimate(ObjectEstimate& out, const Measurement& measured, const Filtered& filtered) {
  out.valid = filtered.valid;
  fill(out.p_measured_m, measured.found ? measured.p_WB : filtered.p_WB);
  if (measured.found && measured.q_WB) fill(out.q_measured, *measured.q_WB);
  fill_motion(out, filtered);
}

/// What one camera saw of an object.
template <typename View>
void fill_detection(ObjectDetection& out, const View& view) noexcept {
  out.found = view.detection.found;
  out.used = view.used;
  out.u_px = view.detection.centre.x();
  out.v_px = view.detection.centre.y();
  out.radius_px = view.detection.radius;
  fill(out.p_WB_m, view.detection.p_WB);
}

/// A client's task, of a sample that was let in.
inline task::Request request(const TaskTarget& sample) {
  task::Request request{sample.kind, {}};
  for (int i = 0; i < sample.parameter_count; ++i) {
    const c3rt_v2_TargetParameter& parameter = sample.parameters[i];
    const double* values = parameter.values;
    request.parameters.push_back(
        {parameter.name, {values, values + parameter.value_count}, parameter.word});
  }
  return request;
}

/// The same the other way. @throws task::RequestError where the wire has no room for it
inline TaskTarget task_target(const task::Request& request) {
  TaskTarget sample{};
  set_text(sample.kind, request.kind);
  const auto most = [](std::size_t count, long room, const std::string& what) {
    if (count > static_cast<std::size_t>(room))
      throw task::RequestError(what + ": expected at most " + std::to_string(room) + ", got " +
                               std::to_string(count));
    return static_cast<std::int32_t>(count);
  };
  sample.parameter_count =
      most(request.parameters.size(), c3rt_v2_MAX_TARGET_PARAMETERS, "parameters");
  for (int i = 0; i < sample.parameter_count; ++i) {
    const task::Parameter& parameter = request.parameters[static_cast<std::size_t>(i)];
    c3rt_v2_TargetParameter& out = sample.parameters[i];
    set_text(out.name, parameter.name);
    set_text(out.word, parameter.word);
    out.value_count =
        most(parameter.values.size(), c3rt_v2_MAX_TARGET_VALUES, "numbers of " + parameter.name);
    std::copy(parameter.values.begin(), parameter.values.end(), out.values);
  }
  return sample;
}

/// A client's weights by their names, of a sample that was let in.
inline std::map<std::string, double> weights(const PlannerWeights& sample) {
  std::map<std::string, double> weights;
  for (int i = 0; i < sample.weight_count; ++i)
    weights[sample.weights[i].name] = sample.weights[i].value;
  return weights;
}

/// The same the other way. @throws std::invalid_argument where the wire has no room for them
inline PlannerWeights planner_weights(const std::map<std::string, double>& weights) {
  PlannerWeights sample{};
  if (weights.size() > c3rt_v2_MAX_WEIGHTS)
    throw std::invalid_argument("weights: expected at most " + std::to_string(c3rt_v2_MAX_WEIGHTS) +
                                ", got " + std::to_string(weights.size()));
  for (const auto& [name, value] : weights) {
    c3rt_v2_Weight& out = sample.weights[sample.weight_count++];
    set_text(out.name, name);
    out.value = value;
  }
  return sample;
}

// Plans. RT: no heap, no lock, no throw.

template <typename Status>
c3rt_v2_PlanStatus wire_plan_status(Status status) noexcept {
  return status == Status::kOk          ? c3rt_v2_PLAN_OK
         : status == Status::kTruncated ? c3rt_v2_PLAN_TRUNCATED
                                        : c3rt_v2_PLAN_FALLBACK;
}

/// The same the other way, of whatever came.
template <typename Status>
Status plan_status(c3rt_v2_PlanStatus status) noexcept {
  switch (status) {
    case c3rt_v2_PLAN_OK:
      return Status::kOk;
    case c3rt_v2_PLAN_TRUNCATED:
      return Status::kTruncated;
    case c3rt_v2_PLAN_FALLBACK:
      return Status::kFallback;
  }
  return Status::kUnknown;
}

/// Goal or knot of a motion, but for its time.
template <typename Goal>
void fill_knot(c3rt_v2_Knot& out, const Goal& goal) noexcept {
  fill(out.p_WE_m, goal.p_WE);
  fill(out.v_WE_m_per_s, goal.v_WE);
  fill(out.q_WE, goal.q_WE);
  fill(out.force_E_n, goal.force_E);
}

template <typename Knot>
Knot knot(const c3rt_v2_Knot& sample) noexcept {
  Knot knot;
  knot.time_ns = sample.time_ns;
  knot.p_WE = vector(sample.p_WE_m);
  knot.v_WE = vector(sample.v_WE_m_per_s);
  knot.q_WE = quaternion(sample.q_WE);
  knot.force_E = vector(sample.force_E_n);
  return knot;
}

/// Status, phase and the one knot of a planner's plan.
template <typename PlannedStep>
void fill_plan(Plan& out, const PlannedStep& plan, std::int64_t at_ns) noexcept {
  out.status = wire_plan_status(plan.status);
  set_text(out.phase, plan.phase);
  out.knot_count = 1;
  out.knots[0].time_ns = at_ns;
  fill_knot(out.knots[0], plan);
}

/// What led to a planner's plan. Matrices are written one step after the other.
template <typename PlannedStep>
void fill_debug(PlannerDebug& out, const PlannedStep& plan) noexcept {
  out.object_index = plan.body;
  fill(out.p_WB_target_m, plan.body_target);
  out.delta_t_c_s = plan.delta_t_c;
  out.state_count = static_cast<int>(plan.x.rows());
  out.force_count = static_cast<int>(plan.lambda.rows());
  out.input_count = static_cast<int>(plan.u.rows());
  fill(out.u_c3, plan.u_c3);
  fill(out.lambda_d, plan.lambda_d);
  fill(out.states, plan.x.reshaped());
  fill(out.forces, plan.lambda.reshaped());
  fill(out.inputs, plan.u.reshaped());
  out.admm_iterations = std::min<int>(plan.admm_iterations, c3rt_v2_MAX_ADMM);
  fill(out.primal_residual, plan.primal_residual.head(std::min<Eigen::Index>(
                                plan.primal_residual.size(), out.admm_iterations)));
  out.complementarity_violation = plan.complementarity_violation;
  out.candidate_count = 0;
  for (const auto& place : plan.weighed) {
    if (!place.known || out.candidate_count == c3rt_v2_MAX_CANDIDATES) continue;
    c3rt_v2_Candidate& candidate = out.candidates[out.candidate_count++];
    fill(candidate.p_WE_m, place.p_WE);
    candidate.cost = place.cost;
  }
}

/// Everything that an impedance controller follows of a plan.
template <typename FollowedPlan>
void read_plan(const Plan& sample, FollowedPlan& plan) noexcept {
  constexpr int kRoom = static_cast<int>(std::tuple_size<decltype(plan.knots)>::value);
  static_assert(c3rt_v2_MAX_KNOTS == kRoom, "room for every knot of a plan");
  plan.session_id = sample.header.session_id;
  plan.stamp_ns = sample.header.time_ns;
  plan.valid_until_ns = sample.valid_until_ns;
  plan.status = plan_status<decltype(plan.status)>(sample.status);
  plan.knot_count = std::clamp(static_cast<int>(sample.knot_count), 0, kRoom);
  for (int i = 0; i < plan.knot_count; ++i) {
    auto& to = plan.knots[static_cast<std::size_t>(i)];
    to = knot<std::decay_t<decltype(to)>>(sample.knots[i]);
  }
}

// Robot and impedance controller. RT: no heap, no lock, no throw.

template <typename Mode>
c3rt_v2_ImpedanceMode impedance_mode(Mode mode) noexcept {
  switch (mode) {
    case Mode::kWait:
      return c3rt_v2_IMPEDANCE_WAIT;
    case Mode::kHold:
      return c3rt_v2_IMPEDANCE_HOLD;
    case Mode::kTrack:
      return c3rt_v2_IMPEDANCE_TRACK;
    case Mode::kStop:
      break;
  }
  return c3rt_v2_IMPEDANCE_STOP;
}

template <typename Mode>
c3rt_v2_RobotMode robot_mode(Mode mode) noexcept {
  switch (mode) {
    case Mode::kIdle:
      return c3rt_v2_ROBOT_IDLE;
    case Mode::kMove:
      return c3rt_v2_ROBOT_MOVE;
    case Mode::kReflex:
      return c3rt_v2_ROBOT_REFLEX;
    case Mode::kUserStopped:
    case Mode::kGuiding:  // of a person, too: robot/contact tells them apart
      return c3rt_v2_ROBOT_USER_STOPPED;
  }
  return c3rt_v2_ROBOT_REFLEX;
}

/// Of the plant's state.
template <typename State>
void fill_robot_state(RobotState& sample, const State& state) noexcept {
  sample = {};
  fill(sample.q_rad, state.q);
  fill(sample.dq_rad_per_s, state.dq);
  fill(sample.tau_nm, state.tau);
  fill(sample.p_WE_m, state.p_WE);
  fill(sample.q_WE, state.q_WE);
  sample.mode = robot_mode(state.mode);
  sample.errors = state.errors;
  sample.command_success_rate = state.command_success_rate;
  sample.command_seq = state.command_seq;
  sample.command_state_ns = state.command_state_ns;
}

/// What acts on the plant's arm, and why it stopped. What is not finite is told as 0.
template <typename State>
void fill_robot_contact(RobotContact& sample, const State& state) noexcept {
  sample = {};
  const auto& external = state.external;
  if (external.tau.allFinite() && external.wrench_W.allFinite()) {
    fill(sample.tau_external_nm, external.tau);
    fill(sample.force_W_n, external.wrench_W.template head<3>());
    fill(sample.torque_W_nm, external.wrench_W.template tail<3>());
    fill(sample.force_E_n, external.wrench_E.template head<3>());
    fill(sample.torque_E_nm, external.wrench_E.template tail<3>());
  }
  sample.joint_contact = state.contacts.joint;
  sample.cartesian_contact = state.contacts.cartesian;
  sample.joint_collision = state.contacts.joint_collision;
  sample.cartesian_collision = state.contacts.cartesian_collision;
  sample.guided = state.mode == std::decay_t<decltype(state.mode)>::kGuiding;
  sample.errors = state.errors;
  const bool caused = *state.cause.unit != '\0';
  sample.error = caused ? static_cast<std::int32_t>(state.cause.error) : -1;
  if (!caused) return;
  sample.axis = state.cause.axis;
  sample.value = std::isfinite(state.cause.value) ? state.cause.value : 0.0;
  sample.limit = state.cause.limit;
}

/// Of an enumeration that has the wire's names.
template <typename Kind>
Kind motion_kind(c3rt_v2_MotionKind kind) noexcept {
  switch (kind) {
    case c3rt_v2_MOTION_JOINT_POSITION:
      return Kind::kJointPosition;
    case c3rt_v2_MOTION_JOINT_VELOCITY:
      return Kind::kJointVelocity;
    case c3rt_v2_MOTION_CARTESIAN_POSE:
      return Kind::kCartesianPose;
    case c3rt_v2_MOTION_CARTESIAN_VELOCITY:
      break;
  }
  return Kind::kCartesianVelocity;
}

/// What a motion generator commands, of a sample that was let in.
template <typename Motion>
void read_motion(const RobotMotion& sample, Motion& motion) noexcept {
  motion = {};
  motion.kind = motion_kind<decltype(motion.kind)>(sample.kind);
  motion.joints =
      vector(sample.kind == c3rt_v2_MOTION_JOINT_VELOCITY ? sample.dq_rad_per_s : sample.q_rad);
  motion.p_WE = vector(sample.p_WE_m);
  motion.q_WE = vector(sample.q_WE);
  motion.V_WE << vector(sample.v_WE_m_per_s), vector(sample.omega_WE_rad_per_s);
  if (sample.has_elbow) motion.elbow = {sample.elbow_q3_rad, sample.elbow_sign};
  motion.last = sample.finished;
}

/// Thresholds of one phase.
template <typename Thresholds>
void read_thresholds(const c3rt_v2_ContactThresholds& sample, Thresholds& thresholds) noexcept {
  thresholds.contact_torque = vector(sample.contact_torque_nm);
  thresholds.collision_torque = vector(sample.collision_torque_nm);
  thresholds.contact_force << vector(sample.contact_force_E_n), vector(sample.contact_torque_E_nm);
  thresholds.collision_force << vector(sample.collision_force_E_n),
      vector(sample.collision_torque_E_nm);
}

/// What an impedance controller needs of it.
template <typename Input>
void read_robot_state(const RobotState& sample, Input& input) noexcept {
  input.session_id = sample.header.session_id;
  input.state_stamp_ns = sample.header.time_ns;
  input.q = vector(sample.q_rad);
  input.dq = vector(sample.dq_rad_per_s);
  input.robot_moves = sample.mode == c3rt_v2_ROBOT_IDLE || sample.mode == c3rt_v2_ROBOT_MOVE;
}

template <typename Output>
void fill_command(RobotCommand& command, const Output& control) noexcept {
  command.mode = impedance_mode(control.mode);
  fill(command.tau_nm, control.tau);
  fill(command.p_WE_desired_m, control.p_WE_desired);
  fill(command.v_WE_desired_m_per_s, control.v_WE_desired);
}

/// Of the plant's state.
template <typename State>
void fill_scene(Scene& sample, const State& state) noexcept {
  sample = {};
  fill(sample.q_rad, state.q);
  fill(sample.p_WE_m, state.p_WE);
  sample.object_count = state.object_count;
  for (int i = 0; i < state.object_count; ++i)
    fill_motion(sample.objects[i], state.objects[static_cast<std::size_t>(i)]);
}

}  // namespace c3rt::wire
