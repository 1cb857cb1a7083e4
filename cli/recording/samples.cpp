#include "cli/recording/samples.hpp"

#include <algorithm>

#include "idl/text.hpp"

namespace c3rt::cli {
namespace {

Eigen::Vector3d vector(const c3rt_v2_Vec3& value) { return {value[0], value[1], value[2]}; }

SceneRow row_of(const wire::Scene& sample) {
  SceneRow row;
  row.time_ns = sample.header.time_ns;
  row.exposure = sample.exposure;
  row.object_count = std::min(static_cast<int>(sample.object_count), kMaxObjects);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.object_count); ++i) {
    const double(&q)[4] = sample.objects[i].q_WB;
    row.p_WB[i] = vector(sample.objects[i].p_WB_m);
    row.q_WB[i] = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }
  return row;
}

StateRow row_of(const wire::RobotState& sample) {
  return {sample.header.time_ns, sample.header.seq,
          vector(sample.p_WE_m), sample.mode == c3rt_v2_ROBOT_REFLEX,
          sample.errors,         sample.command_success_rate};
}

CommandRow row_of(const wire::RobotCommand& sample) {
  return {sample.header.time_ns,
          sample.origin.state_ns,
          sample.origin.exposure_ns,
          sample.origin.plan_ns,
          sample.mode == c3rt_v2_IMPEDANCE_TRACK,
          vector(sample.p_WE_desired_m)};
}

PlanRow row_of(const wire::Plan& sample) {
  return {sample.header.time_ns,
          sample.origin.state_ns,
          sample.origin.exposure_ns,
          wire::is_at_task(sample.phase),
          sample.status == c3rt_v2_PLAN_TRUNCATED,
          sample.status == c3rt_v2_PLAN_FALLBACK,
          sample.solve_time_s};
}

EstimateRow row_of(const wire::ObjectEstimate& sample) {
  const double(&q)[4] = sample.q_measured;
  return {sample.header.time_ns,
          sample.exposure_ns,
          static_cast<int>(sample.object_index),
          sample.valid,
          sample.sensors_used,
          vector(sample.p_measured_m),
          Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
}

}  // namespace

void Samples::keep(const wire::Scene& sample) { series_.scene.push_back(row_of(sample)); }
void Samples::keep(const wire::RobotState& sample) { series_.state.push_back(row_of(sample)); }
void Samples::keep(const wire::RobotCommand& sample) { series_.command.push_back(row_of(sample)); }
void Samples::keep(const wire::Plan& sample) { series_.plan.push_back(row_of(sample)); }
void Samples::keep(const wire::ObjectEstimate& sample) {
  series_.estimate.push_back(row_of(sample));
}
void Samples::keep(const wire::ServiceStatus& sample) {
  const auto process = static_cast<std::size_t>(sample.process);
  if (process < words_.size()) words_[process] = sample;
}

std::string Samples::log_hash() const {
  HashVisitor all;
  for (const wire::Topic& topic : wire::table::kTopics) {
    if (topic.stream == wire::kNoStream) continue;
    const std::uint64_t hash = hashes_[static_cast<std::size_t>(topic.stream)].value();
    if (topic.trait == wire::Trait::kOptional && hash == HashVisitor().value()) continue;
    all("", hash);
  }
  return all.text();
}

}  // namespace c3rt::cli
