#pragma once
// Between the wire's types and the scene's: vectors, rotations, bodies. The one place where that
// is written; what belongs to one room alone (its modes, its plans) is converted in its node.
#include <algorithm>
#include <cstddef>

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
template <typename Sample>
void fill_motion(Sample& out, const scene::Body& body) noexcept {
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

}  // namespace c3rt::wire
