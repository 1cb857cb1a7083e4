#include "vision/node.hpp"

#include <limits>

#include "controller/base/time.hpp"
#include "idl/convert.hpp"
#include "idl/text.hpp"

namespace c3rt::vision {
namespace {

// An end effector that was not heard of for this long may be anywhere [s].
constexpr double kEffectorKnown = 0.1;
// Who has not touched the object for this long may have left it to somebody's hand [s].
constexpr double kAlone = 2.0;

}  // namespace

Node::Node(const Parameters& parameters, const std::vector<ObjectStart>& objects, Source& source)
    : period_ns_(base::nanoseconds(1.0 / parameters.rate)),
      objects_(objects),
      source_(source),
      of_acceleration_(parameters.acceleration_filter) {
  if (of_acceleration_) acceleration_.emplace(*of_acceleration_);
  const bool tags = parameters.source == SourceKind::kCameras && parameters.tags;
  for (const ObjectStart& object : objects_) {
    if (tags && !object.radius) {
      filters_.emplace_back(PoseFilter(parameters.tags->filter));
    } else {
      filters_.emplace_back(Estimator(parameters.estimator, object.radius));
    }
  }
}

const Estimate& Node::estimate(std::size_t index) const noexcept {
  return std::visit([](const auto& filter) -> const Estimate& { return filter.estimate(); },
                    filters_[index]);
}

Prediction Node::prediction(std::size_t index, std::int64_t exposure_ns) const {
  const Estimate& before = estimate(index);
  Prediction expected{objects_[index].p_WB, before.valid || !before.seen};
  if (!before.seen) return expected;
  if (const auto* of_poses = std::get_if<PoseFilter>(&filters_[index])) {
    const Eigen::Isometry3d X_WB = of_poses->predict(exposure_ns);
    expected.p_WB = X_WB.translation();
    expected.q_WB = Eigen::Quaterniond(X_WB.linear());
  } else {
    expected.p_WB = std::get<Estimator>(filters_[index]).predict(exposure_ns);
  }
  return expected;
}

void Node::inject(const wire::FaultInject& fault, std::int64_t now_ns) {
  faults_.begin(fault, now_ns);
  if (fault.kind == c3rt_v2_FAULT_FREEZE_CAMERA)
    source_.freeze(fault.index, wire::end_of(fault, now_ns));
  if (fault.kind == c3rt_v2_FAULT_LOSE_OBJECT) lose_until_ns_ = wire::end_of(fault, now_ns);
  if (fault.kind == c3rt_v2_FAULT_NONE) {
    lose_until_ns_ = 0;
    source_.freeze(-1, 0);
  }
}

void Node::see_effector(std::int64_t time_ns, const Eigen::Vector3d& p_WE) noexcept {
  effector_ns_ = time_ns;
  p_WE_ = p_WE;
}

const Node::Output& Node::step(std::int64_t now_ns) {
  output_.exposure_ns = 0;
  output_.estimates.clear();
  output_.detections.clear();
  output_.events.clear();
  const std::optional<std::int64_t> exposure_ns = source_.exposed();
  if (!exposure_ns || faults_.stalls(now_ns)) return output_;
  output_.exposure_ns = *exposure_ns;
  count_exposure(*exposure_ns);
  predictions_.clear();
  for (std::size_t i = 0; i < filters_.size(); ++i)
    predictions_.push_back(prediction(i, *exposure_ns));
  std::vector<Observation> seen = source_.observe(predictions_);
  for (std::size_t i = 0; i < seen.size(); ++i) observe(i, *exposure_ns, seen[i]);
  return output_;
}

void Node::count_exposure(std::int64_t exposure_ns) {
  if (last_exposure_ns_ != 0) {
    // those in between never arrived, or too late
    const std::int64_t periods = (exposure_ns - last_exposure_ns_ + period_ns_ / 2) / period_ns_;
    if (periods > 1) counters_.dropped_frames += static_cast<std::uint64_t>(periods - 1);
  }
  last_exposure_ns_ = exposure_ns;
  ++counters_.exposures;
}

void Node::observe(std::size_t index, std::int64_t exposure_ns, Observation& seen) {
  const Estimate before = estimate(index);
  if (exposure_ns < lose_until_ns_) {
    seen.measurement.found = false;
    seen.cameras_used = 0;
    for (View& view : seen.views) view.detection.found = view.used = false;
  }
  std::visit([&](auto& filter) { filter.step(seen.measurement); }, filters_[index]);
  const Estimate& now = estimate(index);
  counters_.cameras_used += static_cast<std::uint64_t>(seen.cameras_used);
  tell(index, before, now);

  wire::ObjectEstimate out{};
  out.object_index = static_cast<int>(index);
  wire::set_text(out.name, objects_[index].name);
  out.exposure_ns = exposure_ns;
  out.sensors_used = seen.cameras_used;
  wire::fill_estimate(out, seen.measurement, now);
  if (acceleration_) wire::fill(out.a_WB_m_per_s2, free_acceleration(seen.measurement, now));
  if (faults_.spoils(exposure_ns)) out.p_WB_m[0] = std::numeric_limits<double>::quiet_NaN();
  output_.estimates.push_back(out);

  for (std::size_t i = 0; i < seen.views.size(); ++i) {
    const View& view = seen.views[i];
    if (!view.frame) ++counters_.dropped_frames;
    wire::ObjectDetection detection{};
    detection.camera = static_cast<int>(i);
    detection.object_index = static_cast<int>(index);
    detection.exposure_ns = exposure_ns;
    wire::fill_detection(detection, view);
    output_.detections.push_back(detection);
  }
}

Eigen::Vector2d Node::free_acceleration(const Measurement& seen, const Estimate& estimate) {
  const std::int64_t now_ns = seen.exposure_ns;
  const bool knows =
      estimate.valid && effector_ns_ != 0 && base::seconds(now_ns - effector_ns_) <= kEffectorKnown;
  const double gap = (p_WE_ - estimate.p_WB).norm() - objects_.front().touched_within;
  if (knows && gap < of_acceleration_->gap) touched_ns_ = now_ns;
  if (!knows || base::seconds(now_ns - touched_ns_) > kAlone) touched_ns_ = 0;
  if (touched_ns_ != 0 && estimate.measured) {
    acceleration_->observe(base::seconds(now_ns), seen.p_WB.head<2>(),
                           base::seconds(now_ns - touched_ns_) < of_acceleration_->settle);
  }
  return acceleration_->acceleration();
}

void Node::tell(std::size_t index, const Estimate& before, const Estimate& now) {
  if (now.restarted && before.valid) ++counters_.restarts;
  if (now.valid == before.valid) return;
  if (!now.valid) ++counters_.lost_events;
  std::string lost;
  for (std::size_t i = 0; i < filters_.size(); ++i) {
    const Estimate& of = estimate(i);
    if (of.seen && !of.valid) lost += (lost.empty() ? "" : ", ") + std::to_string(i);
  }
  degraded_ = !lost.empty();
  text_ = degraded_              ? "lost object " + lost
          : filters_.size() == 1 ? "tracks the object"
                                 : "tracks the objects";
  output_.events.push_back("object=" + std::to_string(index) + (now.valid ? " found" : " lost"));
}

}  // namespace c3rt::vision
