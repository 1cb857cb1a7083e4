#pragma once
// Cameras that see the plant's scene: MuJoCo renders it off screen, on the processor (OSMesa).
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "plant_emulator/scene.hpp"
#include "vision/camera.hpp"
#include "vision/parameters.hpp"

namespace c3rt::vision {

/// What was in front of the cameras at an exposure.
struct ScenePose {
  std::int64_t exposure_ns = 0;
  std::array<double, plant::kJoints> q{};  // [rad]
  std::vector<Eigen::Isometry3d> X_WB;     // of every object of the world
};

/// All cameras of the scenario on one rasteriser, which belongs to the thread that made it.
///
/// A frame costs about in proportion to the pixels of the buffer behind it, so there are two
/// buffers: a small one for regions of interest and one for the binned search image.
class VirtualCameras {
 public:
  /// Sets LP_NUM_THREADS=0 in the environment unless it is set: the rasteriser's own threads would
  /// only take processors from the other processes.
  /// @throws std::runtime_error if there is no OSMesa context
  VirtualCameras(const plant::World& world, const Parameters& parameters, std::uint64_t seed);
  ~VirtualCameras();
  VirtualCameras(const VirtualCameras&) = delete;
  VirtualCameras& operator=(const VirtualCameras&) = delete;

  /// All cameras expose at once; they hold this frame until the next exposure.
  void expose(const ScenePose& pose);
  /// They deliver regions no larger, in pixels after binning, than the search image or
  /// detector.roi or tags.region. The cameras in the scenario's order; they live as long as this
  /// object.
  const std::vector<Camera*>& cameras() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace c3rt::vision
