#pragma once
// An estimator or a camera of one's own in the place of c3rt-vision: a class with one method.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "idl/client/motion.hpp"
#include "idl/client/process.hpp"

namespace c3rt::client {

/// Where an object is seen.
struct Estimate {
  int index = 0;             // in the scenario
  Vector p{};                // p_WB of the centre of mass [m]
  Quaternion q{1, 0, 0, 0};  // q_WB
  Vector v{};                // [m/s]
  Vector omega{};            // in W [rad/s]
  bool valid = true;         // false: lost, the numbers are the last good ones
  std::string name = {};
};

/// The estimate as a sample. A quaternion is scaled to norm 1.
/// @throws std::invalid_argument naming what cannot be sent: "index: expected 0 to 7, got 9"
wire::ObjectEstimate estimate_sample(const Estimate& estimate, std::int64_t exposure_ns);

struct EstimatorSettings {
  double rate = 80.0;  // 1 to 1000, of exposures at most theirs [Hz]
  // estimate() is called for each exposure of the emulated cameras; false: at the rate, of images
  // of one's own
  bool of_exposures = true;
  double latency = 0.008;  // lockstep: from the exposure until the estimate is in effect [s]
};

class Estimator : public Process {
 public:
  /// @throws std::invalid_argument naming the setting
  explicit Estimator(const EstimatorSettings& settings = {});
  ~Estimator() override;

  /// Once an exposure. In lockstep it must depend on nothing but what it is given, so that the same
  /// run gives the same bits. What it throws ends the process, as FAILED on service/status.
  /// @param time of the exposure, on the session's clock [s]
  /// @param truth sim/scene at that time, of an emulated plant; else, and before the first, nullptr
  /// @return the objects that are told of; none: nothing is sent
  virtual std::vector<Estimate> estimate(double time, const wire::Scene* truth) = 0;

 private:
  class Seeing;
  std::unique_ptr<Part> take_part(const Place& place) final;
  const EstimatorSettings settings_;
};

}  // namespace c3rt::client
