// What an exposure costs: rendering and detection of all cameras, on the thread that runs it.
#include <string>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include "plant_emulator/load_parameters.hpp"
#include "vision/load_parameters.hpp"
#include "vision/tracker.hpp"
#include "vision/virtual_cameras.hpp"

using namespace c3rt;
using namespace c3rt::vision;

namespace {

constexpr double kRadius = 0.0315;

/// In contact, in a row, the first under the tool.
const std::vector<Eigen::Vector2d> kPlaces = {
    {0.57, 0.02}, {0.57, 0.02 - 2 * kRadius}, {0.57, 0.02 - 4 * kRadius}};

struct Rig {
  explicit Rig(std::size_t balls, ObjectColours colours = ObjectColours::kDistinct)
      : parameters(load_parameters(config::Document::load(std::string(C3RT_SOURCE_DIRECTORY) +
                                                          "/tests/vision/three_cameras.yaml"))),
        cameras(make_world(balls), with(parameters, colours), 1),
        tracker(with(parameters, colours), models(balls), cameras.cameras()) {
    cv::setNumThreads(1);
    pose.q = {0, 0.4, 0, -2.222, 0, 2.622, 0};
    for (std::size_t i = 0; i < balls; ++i) {
      pose.X_WB.emplace_back(Eigen::Isometry3d::Identity());
      pose.X_WB.back().translation() = Eigen::Vector3d(kPlaces[i].x(), kPlaces[i].y(), kRadius);
      known.push_back({pose.X_WB.back().translation(), true});
      unknown.push_back({Eigen::Vector3d(0.55, 0, kRadius), false});
    }
    expose();
  }
  static Parameters with(Parameters p, ObjectColours colours) {
    p.colours = colours;
    return p;
  }
  static std::vector<SphereModel> models(std::size_t balls) {
    std::vector<SphereModel> result;
    for (std::size_t i = 0; i < balls; ++i)
      result.push_back({kRadius, kRadius, plant::kObjectColours.at(i)});
    return result;
  }
  static plant::World make_world(std::size_t balls) {
    plant::World world{};
    world.table_tilt.setZero();
    world.friction = {1, 1};
    world.step = 5e-4;
    world.end_effector = plant::end_effector_of(config::load_robot("panda"));
    for (std::size_t i = 0; i < balls; ++i) {
      plant::ObjectParameters object{};
      object.object =
          scene::solid("ball" + std::to_string(i), scene::Shape::sphere(kRadius), 0.132);
      object.position = kPlaces[i];
      world.objects.push_back(object);
    }
    return world;
  }
  void expose() {
    ++pose.exposure_ns;
    cameras.expose(pose);
  }
  Expectation expected() const { return {pose.X_WB[0].translation(), kRadius, kRadius}; }

  Parameters parameters;
  VirtualCameras cameras;
  Tracker tracker;
  ScenePose pose;
  std::vector<Prediction> known, unknown;
};

Rig& rig() {
  static Rig the_rig(1);
  return the_rig;
}

void expose(benchmark::State& state) {
  Rig& r = rig();
  for (auto _ : state) r.expose();
}

void render_regions(benchmark::State& state) {
  Rig& r = rig();
  cv::Mat image;
  Roi roi;
  for (auto _ : state) {
    for (Camera* camera : r.cameras.cameras()) {
      roi_around(camera->model(), r.expected(), r.parameters.detector.roi, roi);
      camera->grab(r.pose.exposure_ns, roi, image);
    }
  }
}

void detect_in_regions(benchmark::State& state) {
  Rig& r = rig();
  CircleDetector detector(r.parameters.detector);
  const auto& cameras = r.cameras.cameras();
  std::vector<cv::Mat> images(cameras.size());
  std::vector<Roi> rois(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    roi_around(cameras[i]->model(), r.expected(), r.parameters.detector.roi, rois[i]);
    cameras[i]->grab(r.pose.exposure_ns, rois[i], images[i]);
  }
  for (auto _ : state) {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      benchmark::DoNotOptimize(
          detector.detect(cameras[i]->model(), images[i], rois[i], r.expected()));
    }
  }
}

void observe(benchmark::State& state, Rig& r, const std::vector<Prediction>& predictions) {
  for (auto _ : state) {
    r.expose();
    for (const Sighting& sighting : r.tracker.observe(r.pose.exposure_ns, predictions)) {
      if (sighting.fusion.cameras_used < 2)
        state.SkipWithError("a ball is not seen by two cameras");
    }
  }
}

void track(benchmark::State& state) { observe(state, rig(), rig().known); }

void search_one_camera_then_track(benchmark::State& state) { observe(state, rig(), rig().unknown); }

void track_three_balls(benchmark::State& state) {
  static Rig r(3);
  observe(state, r, r.known);
}

void track_three_balls_of_one_colour(benchmark::State& state) {
  static Rig r(3, ObjectColours::kSame);
  observe(state, r, r.known);
}

void track_two_balls_and_search_the_third(benchmark::State& state) {
  static Rig r(3);
  std::vector<Prediction> predictions = r.known;
  predictions[2] = r.unknown[2];
  observe(state, r, predictions);
}

BENCHMARK(expose)->Unit(benchmark::kMillisecond);
BENCHMARK(render_regions)->Unit(benchmark::kMillisecond);
BENCHMARK(detect_in_regions)->Unit(benchmark::kMillisecond);
BENCHMARK(track)->Unit(benchmark::kMillisecond);
BENCHMARK(search_one_camera_then_track)->Unit(benchmark::kMillisecond);
BENCHMARK(track_three_balls)->Unit(benchmark::kMillisecond);
BENCHMARK(track_three_balls_of_one_colour)->Unit(benchmark::kMillisecond);
BENCHMARK(track_two_balls_and_search_the_third)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
