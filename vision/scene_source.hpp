#pragma once
// Sources that look at the plant's scene, and are triggered by its exposures.
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "idl/endpoint.hpp"
#include "plant_emulator/scene.hpp"
#include "vision/node.hpp"
#include "vision/parameters.hpp"
#include "vision/source.hpp"

namespace c3rt::vision {

class SceneSource : public Source {
 public:
  /// Reads sim/scene. Scenes with another number of objects are not looked at: counted, and told
  /// once.
  SceneSource(wire::Bus& bus, wire::Endpoint& endpoint, int objects);

  std::optional<std::int64_t> exposed() final;
  std::vector<Observation> observe(const std::vector<Prediction>& predictions) final {
    return look(newest_, predictions);
  }

 protected:
  wire::Endpoint& endpoint() { return endpoint_; }

 private:
  /// Any scene with the right objects, at an exposure or between two.
  virtual void pass(const wire::Scene&) {}
  virtual std::vector<Observation> look(const wire::Scene& scene,
                                        const std::vector<Prediction>& predictions) = 0;

  wire::Endpoint& endpoint_;
  const int objects_;
  wire::Reader<wire::Scene> scenes_;
  std::atomic<std::uint64_t>& foreign_scenes_;
  wire::Scene newest_{};
};

/// The one that the parameters name.
/// @param seed of its noise, and of the table that the cameras stand on
std::unique_ptr<Source> make_scene_source(wire::Bus& bus, wire::Endpoint& endpoint,
                                          const plant::World& world, const Parameters& parameters,
                                          std::uint64_t seed);

/// What the plant has, before it is seen. Vision knows the table as level.
std::vector<ObjectStart> starts_of(const plant::World& world);

}  // namespace c3rt::vision
