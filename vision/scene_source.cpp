#include "vision/scene_source.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

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
      : SceneSource(bus, endpoint, static_cast<int>(world.objects.size())),
        sensor_(parameters.emulated, seed) {
    for (const plant::ObjectParameters& object : world.objects)
      turned_.push_back(!plant::is_sphere(object));
  }

  void freeze(int, std::int64_t) override {}

 private:
  void pass(const wire::Scene& scene) override {
    std::vector<BodyPose> poses(turned_.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].p_WB = wire::vector(scene.objects[i].p_WB_m);
      if (turned_[i]) poses[i].q_WB = wire::quaternion(scene.objects[i].q_WB);
    }
    sensor_.see(scene.header.time_ns, std::move(poses));
  }

  std::vector<Observation> look(const wire::Scene& scene,
                                const std::vector<Prediction>& predictions) override {
    std::vector<Observation> seen(predictions.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const std::int64_t exposure_ns = scene.header.time_ns;
      const bool in_range = wire::vector(scene.objects[i].p_WB_m).norm() < kRange_m;
      const BodyPose pose = sensor_.measure(i, exposure_ns, turned_[i]);
      seen[i].measurement = {exposure_ns, in_range, pose.p_WB};
      if (turned_[i]) seen[i].measurement.q_WB = pose.q_WB;
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
      : SceneSource(bus, endpoint, static_cast<int>(world.objects.size())),
        rig_(plant::drawn_table(world, seed), parameters, seed) {
    // one thread is faster than two that wait for each other on images this small
    cv::setNumThreads(1);
    std::vector<Camera*> cameras;
    for (Camera* camera : rig_.cameras()) {
      faulty_.push_back(std::make_unique<FaultyCamera>(*camera));
      cameras.push_back(faulty_.back().get());
    }
    std::vector<SphereModel> spheres;
    for (std::size_t i = 0; i < world.objects.size(); ++i) {
      const double radius = world.objects[i].object.shape().radius;
      spheres.push_back({radius, world.table_height + radius, plant::kObjectColours.at(i)});
    }
    tracker_ = std::make_unique<Tracker>(parameters, spheres, cameras);
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
      foreign_scenes_(endpoint.status().counter("scenes_of_other_objects")) {}

std::optional<std::int64_t> SceneSource::exposed() {
  bool any = false;
  wire::Scene scene{};
  while (scenes_.take(scene)) {
    if (scene.object_count == objects_) {
      pass(scene);
      if (!scene.exposure) continue;
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
  for (const plant::ObjectParameters& object : world.objects) {
    const bool rolls = plant::is_sphere(object);
    objects.push_back({object.object.name,
                       rolls ? std::optional<double>(object.object.shape().radius) : std::nullopt,
                       {object.position.x(), object.position.y(),
                        world.table_height + plant::start_height(object)},
                       object.object.shape().radius + world.end_effector.sphere_radius});
  }
  return objects;
}

}  // namespace c3rt::vision
