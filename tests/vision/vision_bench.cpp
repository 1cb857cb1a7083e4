// What an exposure costs: rendering and detection of all cameras, on the thread that runs it.
#include <string>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include "vision/load_parameters.hpp"
#include "vision/tracker.hpp"
#include "vision/virtual_cameras.hpp"

using namespace c3rt;
using namespace c3rt::vision;

namespace {

constexpr double kRadius = 0.0315;

struct Rig {
  Rig()
      : parameters(load_parameters(config::Document::load(std::string(C3RT_SOURCE_DIRECTORY) +
                                                          "/tests/vision/three_cameras.yaml"))),
        world(make_world()),
        cameras(world, parameters, 1),
        tracker(parameters, kRadius, kRadius, cameras.cameras()) {
    cv::setNumThreads(1);
    pose.q = {0, 0.4, 0, -2.222, 0, 2.622, 0};
    pose.X_WB = {Eigen::Isometry3d::Identity()};
    pose.X_WB[0].translation() = Eigen::Vector3d(0.57, 0.02, kRadius);
    expose();
  }
  static plant::World make_world() {
    plant::World world{};
    world.table_tilt.setZero();
    world.friction = {1, 1, 1, 1};
    world.step = 5e-4;
    world.balls = {{{0.55, 0.1}, kRadius, 0.132}};
    return world;
  }
  void expose() {
    ++pose.exposure_ns;
    cameras.expose(pose);
  }
  Expectation expected() const { return {pose.X_WB[0].translation(), kRadius, kRadius}; }

  Parameters parameters;
  plant::World world;
  VirtualCameras cameras;
  Tracker tracker;
  ScenePose pose;
};

Rig& rig() {
  static Rig the_rig;
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

void track(benchmark::State& state) {
  Rig& r = rig();
  for (auto _ : state) {
    r.expose();
    const Sighting sighting =
        r.tracker.observe(r.pose.exposure_ns, r.pose.X_WB[0].translation(), true);
    if (sighting.fusion.cameras_used != 3) state.SkipWithError("a camera does not see the ball");
  }
}

void search_one_camera_then_track(benchmark::State& state) {
  Rig& r = rig();
  for (auto _ : state) {
    r.expose();
    const Sighting sighting =
        r.tracker.observe(r.pose.exposure_ns, Eigen::Vector3d(0.55, 0, kRadius), false);
    if (!sighting.fusion.found) state.SkipWithError("the search does not find the ball");
  }
}

BENCHMARK(expose)->Unit(benchmark::kMillisecond);
BENCHMARK(render_regions)->Unit(benchmark::kMillisecond);
BENCHMARK(detect_in_regions)->Unit(benchmark::kMillisecond);
BENCHMARK(track)->Unit(benchmark::kMillisecond);
BENCHMARK(search_one_camera_then_track)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
