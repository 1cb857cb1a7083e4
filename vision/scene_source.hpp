#pragma once
// Sources that look at the plant's scene, and are triggered by its exposures.
#include <cstdint>
#include <memory>

#include "idl/topics.hpp"
#include "plant_emulator/scene.hpp"
#include "vision/parameters.hpp"
#include "vision/source.hpp"

namespace c3rt::vision {

class SceneSource : public Source {
 public:
  explicit SceneSource(int objects) : objects_(objects) {}
  int objects() const noexcept { return objects_; }

  /// @return false for a scene with another number of objects, which is not looked at
  bool hear(const wire::Scene& scene);
  std::optional<std::int64_t> exposed() final;
  std::vector<Observation> observe(const std::vector<Prediction>& predictions) final {
    return look(newest_, predictions);
  }

 private:
  virtual std::vector<Observation> look(const wire::Scene& scene,
                                        const std::vector<Prediction>& predictions) = 0;

  const int objects_;
  bool new_ = false;
  wire::Scene newest_{};
};

/// The one that the parameters name.
/// @param seed of its noise, and of the table that the cameras stand on
std::unique_ptr<SceneSource> make_scene_source(const plant::World& world,
                                               const Parameters& parameters, std::uint64_t seed);

}  // namespace c3rt::vision
