#include "vision/scene_source.hpp"

#include <algorithm>
#include <iterator>

#include <opencv2/core/utility.hpp>

#include "idl/convert.hpp"
#include "plant_emulator/start.hpp"
#include "vision/emulated.hpp"
#include "vision/faulty_camera.hpp"
#include "vision/virtual_cameras.hpp"

namespace c3rt::vision {
namespace {

class EmulatedSource : public SceneSource {
 public:
  EmulatedSource(wire::Bus& bus, wire::Endpoint& endpoint, const plant::World& world,
                 const Parameters& parameters, std::uint64_t seed)
      : SceneSource(bus, endpoint, static_cast<int>(world.balls.size())),
        sensor_(parameters.emulated, seed) {
    for (const plant::BallParameters& object : world.balls)
      turned_.push_back(object.half_sizes.has_value());
  }

  void freeze(int, std::int64_t) override {}

 private:
  std::vector<Observation> look(const wire::Scene& scene,
                                const std::vector<Prediction>& predictions) override {
    std::vector<Observation> seen(predictions.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Eigen::Vector3d truth = wire::vector(scene.objects[i].p_WB_m);
      seen[i].measurement = {scene.header.time_ns, truth.norm() < kRange_m, sensor_.measure(truth)};
      if (turned_[i])
        seen[i].measurement.q_WB = sensor_.measure(wire::quaternion(scene.objects[i].q_WB));
      seen[i].cameras_used = 1;
    }
    return seen;
  }

  static constexpr double kRange_m = 5.0;  // no camera of this table sees farther
  EmulatedSensor sensor_;
  std::vector<bool> turned_;  // by object: whether its orientation shows
};

class CameraSource : public SceneSource {
 public:
  CameraSource(wire::Bus& bus, wire::Endpoint& endpoint, const plant::World& world,
               const Parameters& parameters, std::uint64_t seed)
      : SceneSource(bus, endpoint, static_cast<int>(world.balls.size())),
        rig_(plant::drawn_table(world, seed), parameters, seed) {
    // one thread is faster than two that wait for each other on images this small
    cv::setNumThreads(1);
    std::vector<Camera*> cameras;
    for (Camera* camera : rig_.cameras()) {
      faulty_.push_back(std::make_unique<FaultyCamera>(*camera));
      cameras.push_back(faulty_.back().get());
    }
    std::vector<SphereModel> balls;
    for (std::size_t i = 0; i < world.balls.size(); ++i) {
      const double radius = world.balls[i].radius;
      balls.push_back({radius, world.table_height + radius, plant::kBallColours.at(i)});
    }
    tracker_ = std::make_unique<Tracker>(parameters, balls, cameras);
  }

  void freeze(int camera, std::int64_t until_ns) override {
    for (int i = 0; i < static_cast<int>(faulty_.size()); ++i) {
      if (camera < 0 || camera == i) faulty_[static_cast<std::size_t>(i)]->freeze(until_ns);
    }
  }

 private:
  std::vector<Observation> look(const wire::Scene& scene,
                                const std::vector<Prediction>& predictions) override {
    expose(scene);
    std::vector<Observation> seen;
    for (const Sighting& sighting : tracker_->observe(pose_.exposure_ns, predictions)) {
      seen.push_back({{pose_.exposure_ns, sighting.fusion.found, sighting.fusion.p_WB},
                      sighting.fusion.cameras_used,
                      sighting.views});
    }
    return seen;
  }

  void expose(const wire::Scene& scene) {
    pose_.exposure_ns = scene.header.time_ns;
    std::copy(std::begin(scene.q_rad), std::end(scene.q_rad), pose_.q.begin());
    pose_.X_WB.resize(static_cast<std::size_t>(scene.object_count));
    for (int i = 0; i < scene.object_count; ++i) {
      Eigen::Isometry3d& X_WB = pose_.X_WB[static_cast<std::size_t>(i)];
      X_WB = wire::quaternion(scene.objects[i].q_WB);
      X_WB.translation() = wire::vector(scene.objects[i].p_WB_m);
    }
    rig_.expose(pose_);
  }

  VirtualCameras rig_;
  std::vector<std::unique_ptr<FaultyCamera>> faulty_;
  std::unique_ptr<Tracker> tracker_;
  ScenePose pose_;
};

}  // namespace

SceneSource::SceneSource(wire::Bus& bus, wire::Endpoint& endpoint, int objects)
    : endpoint_(endpoint),
      objects_(objects),
      scenes_(bus),
      foreign_scenes_(endpoint.status().counter("scenes_of_other_balls")) {}

std::optional<std::int64_t> SceneSource::exposed() {
  bool any = false;
  wire::Scene scene{};
  while (scenes_.take(scene)) {
    if (!scene.exposure) continue;
    if (scene.object_count == objects_) {
      any = true;
      newest_ = scene;
    } else if (foreign_scenes_++ == 0) {
      endpoint_.tell(true, "the scene has " + std::to_string(scene.object_count) +
                               " objects, this scenario " + std::to_string(objects_) +
                               ": not looked at");
    }
  }
  if (!any) return {};
  return newest_.header.time_ns;
}

std::unique_ptr<Source> make_scene_source(wire::Bus& bus, wire::Endpoint& endpoint,
                                          const plant::World& world, const Parameters& parameters,
                                          std::uint64_t seed) {
  if (parameters.source == SourceKind::kEmulated) {
    return std::make_unique<EmulatedSource>(bus, endpoint, world, parameters, seed);
  }
  return std::make_unique<CameraSource>(bus, endpoint, world, parameters, seed);
}

std::vector<ObjectStart> starts_of(const plant::World& world) {
  std::vector<ObjectStart> objects;
  for (std::size_t i = 0; i < world.balls.size(); ++i) {
    const plant::BallParameters& ball = world.balls[i];
    // named as in the plant's model; vision knows the table as level
    const double height = ball.half_sizes ? ball.half_sizes->z() : ball.radius;
    objects.push_back({plant::object_name(world, static_cast<int>(i)),
                       ball.half_sizes ? std::nullopt : std::optional<double>(ball.radius),
                       {ball.position.x(), ball.position.y(), world.table_height + height},
                       ball.radius + world.end_effector.sphere_radius});
  }
  return objects;
}

}  // namespace c3rt::vision
