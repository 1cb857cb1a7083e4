#include "vision/emulated.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "controller/base/time.hpp"

namespace c3rt::vision {

void EmulatedSensor::see(std::int64_t time_ns, std::vector<BodyPose> poses) {
  seen_.push_back({time_ns, std::move(poses)});
  // one that is old enough stays, to interpolate from
  const std::int64_t oldest_ns = time_ns - base::nanoseconds(parameters_.delay + kLate);
  while (seen_.size() > 1 && seen_[1].time_ns <= oldest_ns) seen_.pop_front();
}

BodyPose EmulatedSensor::pose_at(std::size_t body, std::int64_t time_ns) const {
  const auto after = std::find_if(seen_.begin(), seen_.end(), [&](const Instant& instant) {
    return instant.time_ns >= time_ns;
  });
  if (after == seen_.end()) return seen_.back().poses.at(body);
  const BodyPose& later = after->poses.at(body);
  if (after == seen_.begin() || after->time_ns == time_ns) return later;
  const Instant& before = *std::prev(after);
  const double share = static_cast<double>(time_ns - before.time_ns) /
                       static_cast<double>(after->time_ns - before.time_ns);
  const BodyPose& earlier = before.poses.at(body);
  BodyPose between;
  between.p_WB = earlier.p_WB + share * (later.p_WB - earlier.p_WB);
  between.q_WB = Eigen::Quaterniond(earlier.q_WB).slerp(share, Eigen::Quaterniond(later.q_WB));
  return between;
}

const Eigen::Vector3d& EmulatedSensor::drift(std::size_t body, std::int64_t exposure_ns) {
  if (drifts_.size() <= body) drifts_.resize(body + 1);
  Drift& drift = drifts_[body];
  const double since = std::max(0.0, base::seconds(exposure_ns - drift.time_ns));
  // it has been there for ever when it is first looked at
  const double left = drift.time_ns == 0 ? 0.0 : std::exp(-since / parameters_.drift_time);
  const double fresh = std::sqrt(1.0 - left * left);
  const Eigen::Vector3d sigma(parameters_.drift, parameters_.drift, parameters_.angle_drift);
  for (int axis = 0; axis < 3; ++axis) {
    drift.error[axis] = left * drift.error[axis] + fresh * sigma[axis] * drift_random_.normal();
  }
  drift.time_ns = exposure_ns;
  return drift.error;
}

BodyPose EmulatedSensor::measure(std::size_t body, std::int64_t exposure_ns, bool turned) {
  BodyPose measured = pose_at(body, exposure_ns - base::nanoseconds(parameters_.delay));
  const Eigen::Vector3d& drifted = drift(body, exposure_ns);
  // drawn also without noise, so that the sequence of a seed never depends on sigma
  for (int axis = 0; axis < 2; ++axis) {
    measured.p_WB[axis] +=
        std::clamp(parameters_.noise * random_.normal(), -parameters_.clip, parameters_.clip);
    measured.p_WB[axis] += drifted[axis];
  }
  if (turned) {
    const double angle = parameters_.angle_noise * random_.normal() + drifted[2];
    measured.q_WB =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(measured.q_WB);
  }
  return measured;
}

}  // namespace c3rt::vision
