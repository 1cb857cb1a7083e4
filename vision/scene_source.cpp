#include "vision/scene_source.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "idl/convert.hpp"
#include "plant_emulator/start.hpp"
#include "vision/emulated.hpp"
#include "vision/faulty_camera.hpp"
#include "vision/tag_tracker.hpp"
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
    std::vector<TaggedObject> tagged;
    for (std::size_t i = 0; i < world.objects.size(); ++i) {
      const scene::Object& object = world.objects[i].object;
      const bool sphere = plant::is_sphere(world.objects[i]);
      const double radius = object.shape().radius;
      if (sphere)
        spheres.push_back({radius, world.table_height + radius, plant::kObjectColours.at(i)});
      if (!sphere) tagged.push_back({object.name, object.tags});
      (sphere ? of_spheres_ : of_tagged_).push_back(i);
    }
    if (!spheres.empty()) spheres_.emplace(parameters, spheres, cameras);
    if (tagged.empty()) return;
    if (!parameters.tags)
      throw std::invalid_argument("cameras: objects with tags need the parameters of tags");
    tagged_.emplace(*parameters.tags, parameters.detector.search_binning, tagged, cameras);
    unknown_ = &endpoint.status().counter("tags_unknown");
    twice_ = &endpoint.status().counter("tags_twice");
    outliers_ = &endpoint.status().counter("tag_outliers");
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
    std::vector<Observation> seen(predictions.size());
    if (spheres_) look_at_spheres(predictions, seen);
    if (tagged_) look_at_tags(predictions, seen);
    return seen;
  }

  static std::vector<Prediction> only(const std::vector<std::size_t>& of,
                                      const std::vector<Prediction>& all) {
    std::vector<Prediction> some;
    for (const std::size_t i : of) some.push_back(all[i]);
    return some;
  }

  void look_at_spheres(const std::vector<Prediction>& predictions, std::vector<Observation>& seen) {
    const auto& sightings = spheres_->observe(pose_.exposure_ns, only(of_spheres_, predictions));
    for (std::size_t k = 0; k < sightings.size(); ++k) {
      const Sighting& sighting = sightings[k];
      seen[of_spheres_[k]] = {{pose_.exposure_ns, sighting.fusion.found, sighting.fusion.p_WB},
                              sighting.fusion.cameras_used,
                              sighting.views};
    }
  }

  void look_at_tags(const std::vector<Prediction>& predictions, std::vector<Observation>& seen) {
    const auto& sightings = tagged_->observe(pose_.exposure_ns, only(of_tagged_, predictions));
    for (std::size_t k = 0; k < sightings.size(); ++k) {
      const TagSighting& sighting = sightings[k];
      Measurement measurement{pose_.exposure_ns, sighting.fit.found, sighting.fit.p_WB};
      measurement.q_WB = sighting.fit.q_WB;
      measurement.covariance = sighting.fit.covariance;
      seen[of_tagged_[k]] = {measurement, sighting.cameras_used, sighting.views};
    }
    *unknown_ = tagged_->counts().unknown;
    *twice_ = tagged_->counts().twice;
    *outliers_ = tagged_->counts().outliers;
    for (const std::string& notice : tagged_->take_notices()) endpoint().tell(true, notice);
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
  std::vector<std::size_t> of_spheres_, of_tagged_;  // which of the scene's objects
  std::optional<Tracker> spheres_;
  std::optional<TagTracker> tagged_;
  std::atomic<std::uint64_t>*unknown_ = nullptr, *twice_ = nullptr, *outliers_ = nullptr;
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
