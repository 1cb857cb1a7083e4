#pragma once
// Vision on the types of the wire: exposures in, estimates out. No bus, no clock, no thread:
// c3rt-vision gives it both clocks, a test gives it neither.
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "idl/faults.hpp"
#include "vision/parameters.hpp"
#include "vision/source.hpp"

namespace c3rt::vision {

/// What there is to know of an object before it is seen.
struct ObjectStart {
  std::string name;              // as in the plant's model
  std::optional<double> radius;  // of a sphere, which rolls; none: its orientation is measured [m]
  Eigen::Vector3d p_WB;
  double touched_within = 0.0;  // of centre and the end effector's: then their surfaces touch [m]
};

class Node {
 public:
  struct Output {
    std::int64_t exposure_ns = 0;  // 0: there was none, and the rest is empty
    std::vector<wire::ObjectEstimate> estimates;
    std::vector<wire::ObjectDetection> detections;
    std::vector<std::string> events;  // a sentence for each object that was found or lost
  };
  struct Counters {
    std::uint64_t exposures = 0, dropped_frames = 0, cameras_used = 0, lost_events = 0,
                  restarts = 0;
  };

  Node(const Parameters& parameters, const std::vector<ObjectStart>& objects, Source& source);

  /// What the source has seen since the last step; valid until the next one.
  const Output& step(std::int64_t now_ns);
  /// Where the end effector is: only what it does not touch rolls freely.
  void see_effector(std::int64_t time_ns, const Eigen::Vector3d& p_WE) noexcept;
  /// Of a fault that was let in.
  void inject(const wire::FaultInject& fault, std::int64_t now_ns);

  const Counters& counters() const noexcept { return counters_; }
  bool degraded() const noexcept { return degraded_; }
  const std::string& text() const noexcept { return text_; }  // a sentence for a person

 private:
  void count_exposure(std::int64_t exposure_ns);
  void observe(std::size_t index, std::int64_t exposure_ns, Observation& seen);
  /// What accelerates the object that the end effector has touched and nobody touches now.
  Eigen::Vector2d free_acceleration(const Measurement& seen, const Estimate& estimate);
  void tell(std::size_t index, const Estimate& before, const Estimate& now);
  const Estimate& estimate(std::size_t index) const noexcept;
  Prediction prediction(std::size_t index, std::int64_t exposure_ns) const;

  const std::int64_t period_ns_;
  const std::vector<ObjectStart> objects_;
  Source& source_;
  // by object: of positions, or of poses with their covariance
  std::vector<std::variant<Estimator, PoseFilter>> filters_;
  std::vector<Prediction> predictions_;
  const std::optional<AccelerationFilterParameters> of_acceleration_;
  std::optional<AccelerationFilter> acceleration_;
  Eigen::Vector3d p_WE_ = Eigen::Vector3d::Zero();
  std::int64_t effector_ns_ = 0;  // of p_WE_; 0: none yet
  std::int64_t touched_ns_ = 0;   // the end effector was last near the object; 0: not lately
  Output output_;
  Counters counters_;
  bool degraded_ = false;
  std::string text_ = "waits for the first exposure";
  wire::FaultWindows faults_;
  std::int64_t lose_until_ns_ = 0;
  std::int64_t last_exposure_ns_ = 0;
};

}  // namespace c3rt::vision
