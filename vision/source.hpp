#pragma once
// Where measurements come from. A source has a trigger of its own: the emulated one and the virtual
// cameras are triggered by the plant's scene (scene_source.hpp), a real camera by its frames.
#include <cstdint>
#include <optional>
#include <vector>

#include "vision/track/estimator.hpp"
#include "vision/tracker.hpp"

namespace c3rt::vision {

/// One object at one exposure.
struct Observation {
  Measurement measurement;
  int cameras_used = 0;
  std::vector<View> views;
};

class Source {
 public:
  Source() = default;
  virtual ~Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  /// The newest exposure since the last call, if there is one; observe() is then about it. Of
  /// several only the newest is worth its time.
  virtual std::optional<std::int64_t> exposed() = 0;
  /// @param predictions by object, as the result
  virtual std::vector<Observation> observe(const std::vector<Prediction>& predictions) = 0;
  /// A fault: what the camera shows stays as it is. A negative index means all.
  virtual void freeze(int camera, std::int64_t until_ns) = 0;
};

}  // namespace c3rt::vision
