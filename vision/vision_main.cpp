// c3rt-vision: what the cameras see of the plant's scene in, the balls' states out, once per
// exposure.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/utility.hpp>
#include <spdlog/spdlog.h>

#include "config/process_options.hpp"
#include "config/scenario.hpp"
#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "controller/rt/thread_setup.hpp"
#include "idl/bus_settings.hpp"
#include "idl/dds.hpp"
#include "idl/endpoint.hpp"
#include "idl/process.hpp"
#include "idl/shutdown_listener.hpp"
#include "idl/text.hpp"
#include "plant_emulator/start.hpp"
#include "vision/emulated.hpp"
#include "vision/faulty_camera.hpp"
#include "vision/tracker.hpp"
#include "vision/virtual_cameras.hpp"

namespace c3rt::vision {
namespace {

constexpr int kPriority = 30;  // above ordinary programs, below all that closes the 1 kHz loop
constexpr std::int64_t kPollNs =
    50'000'000;  // realtime: a blocked wait looks at the stop flag this often

using base::nanoseconds;

void fill(double (&out)[3], const Eigen::Vector3d& v) { std::copy_n(v.data(), 3, out); }
void fill(double (&out)[4], const Eigen::Quaterniond& q) {
  const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
  std::copy_n(wxyz, 4, out);
}

/// One ball at one exposure, whatever the source.
struct Observation {
  Measurement measurement;
  int cameras_used = 0;
  std::vector<View> views;
};

/// Where measurements come from; chosen by the scenario.
class Source {
 public:
  virtual ~Source() = default;
  virtual void expose(const wire::Scene& scene) = 0;
  /// @param predictions by ball, as the result
  virtual std::vector<Observation> observe(const std::vector<Prediction>& predictions) = 0;
  virtual void freeze(int camera, std::int64_t until_ns) = 0;  // a negative index means all
};

class EmulatedSource : public Source {
 public:
  EmulatedSource(const Parameters& parameters, std::uint64_t seed)
      : sensor_(parameters.emulated, seed) {}

  void expose(const wire::Scene& scene) override { scene_ = scene; }
  std::vector<Observation> observe(const std::vector<Prediction>& predictions) override {
    std::vector<Observation> seen(predictions.size());
    for (std::size_t ball = 0; ball < seen.size(); ++ball) {
      const Eigen::Vector3d truth = Eigen::Map<const Eigen::Vector3d>(scene_.objects[ball].p_WB_m);
      seen[ball].measurement = {scene_.header.time_ns, truth.norm() < kRange_m,
                                sensor_.measure(truth)};
      seen[ball].cameras_used = 1;
    }
    return seen;
  }
  void freeze(int, std::int64_t) override {}

 private:
  static constexpr double kRange_m = 5.0;  // no camera of this table sees farther
  EmulatedSensor sensor_;
  wire::Scene scene_{};
};

class CameraSource : public Source {
 public:
  CameraSource(const config::Scenario& scenario, std::uint64_t seed)
      : rig_(plant::drawn_table(scenario.plant.world, seed), scenario.vision, seed) {
    std::vector<Camera*> cameras;
    for (Camera* camera : rig_.cameras()) {
      faulty_.push_back(std::make_unique<FaultyCamera>(*camera));
      cameras.push_back(faulty_.back().get());
    }
    const plant::World& world = scenario.plant.world;
    std::vector<BallModel> balls;
    for (std::size_t i = 0; i < world.balls.size(); ++i) {
      const double radius = world.balls[i].radius;
      balls.push_back({radius, world.table_height + radius, plant::kBallColours.at(i)});
    }
    tracker_ = std::make_unique<Tracker>(scenario.vision, balls, cameras);
  }

  void expose(const wire::Scene& scene) override {
    pose_.exposure_ns = scene.header.time_ns;
    std::copy(std::begin(scene.q_rad), std::end(scene.q_rad), pose_.q.begin());
    pose_.X_WB.resize(static_cast<std::size_t>(scene.object_count));
    for (int i = 0; i < scene.object_count; ++i) {
      const auto& q = scene.objects[i].q_WB;
      Eigen::Isometry3d& X_WB = pose_.X_WB[static_cast<std::size_t>(i)];
      X_WB = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
      X_WB.translation() = Eigen::Map<const Eigen::Vector3d>(scene.objects[i].p_WB_m);
    }
    rig_.expose(pose_);
  }
  std::vector<Observation> observe(const std::vector<Prediction>& predictions) override {
    std::vector<Observation> seen;
    for (const Sighting& sighting : tracker_->observe(pose_.exposure_ns, predictions)) {
      seen.push_back({{pose_.exposure_ns, sighting.fusion.found, sighting.fusion.p_WB},
                      sighting.fusion.cameras_used,
                      sighting.views});
    }
    return seen;
  }
  void freeze(int camera, std::int64_t until_ns) override {
    for (int i = 0; i < static_cast<int>(faulty_.size()); ++i) {
      if (camera < 0 || camera == i) faulty_[static_cast<std::size_t>(i)]->freeze(until_ns);
    }
  }

 private:
  VirtualCameras rig_;
  std::vector<std::unique_ptr<FaultyCamera>> faulty_;
  std::unique_ptr<Tracker> tracker_;
  ScenePose pose_;
};

std::unique_ptr<Source> make_source(const config::Scenario& scenario, std::uint64_t seed) {
  if (scenario.vision.source == SourceKind::kEmulated) {
    return std::make_unique<EmulatedSource>(scenario.vision, seed);
  }
  return std::make_unique<CameraSource>(scenario, seed);
}

/// From exposures to samples: the same in both clocks.
class Service {
 public:
  Service(const config::Scenario& scenario, const config::ProcessOptions& options, wire::Bus& bus,
          wire::Endpoint& endpoint)
      : realtime_(options.clock == config::Clock::kRealtime),
        latency_ns_(nanoseconds(scenario.timing.vision_latency_s)),
        period_ns_(nanoseconds(1.0 / scenario.vision.rate)),
        source_(make_source(scenario, options.seed)),
        scenes_(bus),
        detections_(bus),
        estimates_(bus),
        endpoint_(endpoint),
        exposures_(endpoint.status().counter("exposures")),
        dropped_(endpoint.status().counter("dropped_frames")),
        cameras_used_(endpoint.status().counter("cameras_used")),
        lost_events_(endpoint.status().counter("lost_events")),
        restarts_(endpoint.status().counter("restarts")),
        foreign_scenes_(endpoint.status().counter("scenes_of_other_balls")) {
    const plant::World& world = scenario.plant.world;
    for (std::size_t i = 0; i < world.balls.size(); ++i) {
      estimators_.emplace_back(scenario.vision.estimator, world.balls[i].radius);
      // vision knows the table as level
      const Eigen::Vector2d& start = world.balls[i].position;
      start_.emplace_back(start.x(), start.y(), world.table_height + world.balls[i].radius);
    }
    endpoint_.say(c3rt_v2_SERVICE_RUNNING, "waits for the first exposure");
  }

  /// Everything that has arrived.
  void serve(std::int64_t now_ns) {
    serve_clients(now_ns);
    wire::Scene scene{};
    bool exposed = false;
    wire::Scene newest{};
    while (scenes_.take(scene)) {
      if (!scene.exposure || !is_ours(scene)) continue;
      exposed = true;  // of several only the newest is worth its time
      newest = scene;
    }
    if (exposed && !faults_.stalls(now_ns)) process(newest);
  }

 private:
  void serve_clients(std::int64_t now_ns) {
    endpoint_.serve_requests(now_ns, [](c3rt_v2_RequestVerb) -> std::optional<wire::Answer> {
      return wire::Answer{false, "vision knows only shutdown"};
    });
    endpoint_.serve_faults(now_ns, [this, now_ns](const wire::FaultInject& fault) {
      faults_.begin(fault, now_ns);
      if (fault.kind == c3rt_v2_FAULT_FREEZE_CAMERA)
        source_->freeze(fault.index, wire::end_of(fault, now_ns));
      if (fault.kind == c3rt_v2_FAULT_LOSE_OBJECT) lose_ball_ns_ = wire::end_of(fault, now_ns);
      if (fault.kind == c3rt_v2_FAULT_NONE) {
        lose_ball_ns_ = 0;
        source_->freeze(-1, 0);
      }
      return std::string();
    });
  }

  /// Of as many balls as the scenario has; told once where not.
  bool is_ours(const wire::Scene& scene) {
    const int ours = static_cast<int>(estimators_.size());
    if (scene.object_count == ours) return true;
    ++foreign_scenes_;
    if (foreign_scenes_ == 1)
      spdlog::warn("the scene has {} objects, this scenario {}: not looked at", scene.object_count,
                   ours);
    return false;
  }

  void process(const wire::Scene& scene) {
    const std::int64_t began_ns = rt::now_ns();
    const std::int64_t exposure_ns = scene.header.time_ns;
    if (last_exposure_ns_ != 0) {
      // those in between never arrived, or too late
      const std::int64_t periods = (exposure_ns - last_exposure_ns_ + period_ns_ / 2) / period_ns_;
      if (periods > 1) dropped_ += static_cast<std::uint64_t>(periods - 1);
    }
    last_exposure_ns_ = exposure_ns;
    ++exposures_;
    if (realtime_) {
      endpoint_.status().wakeup_latency().add(1e-9 * static_cast<double>(began_ns - exposure_ns));
    }
    source_->expose(scene);
    std::vector<Prediction> predictions;
    for (std::size_t i = 0; i < estimators_.size(); ++i) {
      const Estimate& before = estimators_[i].estimate();
      predictions.push_back({before.seen ? estimators_[i].predict(exposure_ns) : start_[i],
                             before.valid || !before.seen});
    }
    std::vector<Observation> seen = source_->observe(predictions);
    for (std::size_t i = 0; i < seen.size(); ++i) process_ball(i, exposure_ns, seen[i]);
    endpoint_.status().compute().add(1e-9 * static_cast<double>(rt::now_ns() - began_ns));
  }

  void process_ball(std::size_t index, std::int64_t exposure_ns, Observation& seen) {
    Estimator& estimator = estimators_[index];
    const int ball = static_cast<int>(index);
    const Estimate before = estimator.estimate();
    if (exposure_ns < lose_ball_ns_) {
      seen.measurement.found = false;
      seen.cameras_used = 0;
      for (View& view : seen.views) view.detection.found = view.used = false;
    }
    const Estimate& estimate = estimator.step(seen.measurement);
    cameras_used_ += static_cast<std::uint64_t>(seen.cameras_used);
    report(ball, before, estimate);

    const std::int64_t published_ns = realtime_ ? rt::now_ns() : exposure_ns + latency_ns_;
    wire::ObjectEstimate out{};
    out.object_index = ball;
    wire::set_text(out.name, "ball" + std::to_string(ball));  // as in the plant's model
    out.exposure_ns = exposure_ns;
    out.valid = estimate.valid;
    out.sensors_used = seen.cameras_used;
    fill(out.p_measured_m, seen.measurement.found ? seen.measurement.p_WB : estimate.p_WB);
    fill(out.p_WB_m, estimate.p_WB);
    fill(out.v_WB_m_per_s, estimate.v_WB);
    fill(out.omega_rad_per_s, estimate.omega_WB);
    fill(out.q_WB, estimate.q_WB);
    if (faults_.spoils(exposure_ns)) out.p_WB_m[0] = std::nan("");
    estimates_.write(out, published_ns);

    // after the estimate: nobody waits for these
    for (std::size_t i = 0; i < seen.views.size(); ++i) {
      const View& view = seen.views[i];
      if (!view.frame) ++dropped_;
      wire::ObjectDetection detection{};
      detection.camera = static_cast<int>(i);
      detection.object_index = ball;
      detection.exposure_ns = exposure_ns;
      detection.found = view.detection.found;
      detection.used = view.used;
      detection.u_px = view.detection.centre.x();
      detection.v_px = view.detection.centre.y();
      detection.radius_px = view.detection.radius;
      fill(detection.p_WB_m, view.detection.p_WB);
      detections_.write(detection, published_ns);
    }
  }

  void report(int ball, const Estimate& before, const Estimate& now) {
    if (now.restarted && before.valid) ++restarts_;
    if (now.valid == before.valid) return;
    if (!now.valid) ++lost_events_;
    std::string lost;
    for (std::size_t i = 0; i < estimators_.size(); ++i) {
      const Estimate& estimate = estimators_[i].estimate();
      if (estimate.seen && !estimate.valid) lost += (lost.empty() ? "" : ", ") + std::to_string(i);
    }
    if (lost.empty()) {
      endpoint_.say(c3rt_v2_SERVICE_RUNNING,
                    estimators_.size() == 1 ? "tracks the ball" : "tracks the balls");
    } else {
      endpoint_.say(c3rt_v2_SERVICE_DEGRADED, "lost ball " + lost);
    }
    spdlog::info("ball={} {}", ball, now.valid ? "found" : "lost");
  }

  const bool realtime_;
  const std::int64_t latency_ns_, period_ns_;
  std::unique_ptr<Source> source_;
  wire::Reader<wire::Scene> scenes_;
  wire::Writer<wire::ObjectDetection> detections_;
  wire::Writer<wire::ObjectEstimate> estimates_;
  wire::Endpoint& endpoint_;
  std::atomic<std::uint64_t>&exposures_, &dropped_, &cameras_used_, &lost_events_, &restarts_,
      &foreign_scenes_;
  std::vector<Estimator> estimators_;
  std::vector<Eigen::Vector3d> start_;
  wire::FaultWindows faults_;
  std::int64_t lose_ball_ns_ = 0;  // until then
  std::int64_t last_exposure_ns_ = 0;
};

void run_realtime(wire::Bus& bus, Service& service) {
  const std::string refused = rt::setup_thread({kPriority, {}, false});
  if (!refused.empty()) spdlog::warn("not real-time: {}", refused);
  const wire::ShutdownListener shutdown(bus, c3rt_v2_PROCESS_VISION);
  while (!wire::StopFlag::requested()) {
    bus.wait_for_data(kPollNs);
    service.serve(rt::now_ns());
  }
}

/// @return why it ended, empty for a requested stop
std::string run_lockstep(wire::Bus& bus, Service& service, double rate) {
  wire::Loop loop(bus, {c3rt_v2_PROCESS_VISION, nanoseconds(1.0 / rate)});
  std::int64_t now_ns = 0;
  while (loop.wait(now_ns)) service.serve(now_ns);
  return loop.failure();
}

void tell(bool attention, const std::string& said) {
  spdlog::log(attention ? spdlog::level::warn : spdlog::level::info, "{}", said);
}

int run(int argc, char** argv) {
  int exit_status = 0;
  const auto options = config::parse_process_options(
      argc, argv, "c3rt-vision",
      "Three virtual cameras, or an emulated sensor: the balls' positions, velocities and spin.",
      exit_status);
  if (!options) return exit_status;
  const wire::StopFlag stop;
  // one thread is faster than two that wait for each other on images this small
  cv::setNumThreads(1);
  const config::Scenario scenario =
      config::load_scenario(options->scenario_path, options->overrides);
  const bool lockstep = options->clock == config::Clock::kLockstep;
  wire::Bus bus(wire::bus_settings(*options));
  wire::FaultScope scope;
  const bool cameras = scenario.vision.source == SourceKind::kCameras;
  scope.cameras = cameras ? static_cast<int>(scenario.vision.cameras.size()) : 0;
  wire::Endpoint endpoint(bus, c3rt_v2_PROCESS_VISION, scope, tell);
  Service service(scenario, *options, bus, endpoint);
  spdlog::info("start scenario={} source={} rate_hz={} cameras={}", scenario.name,
               cameras ? "cameras" : "emulated", scenario.vision.rate,
               scenario.vision.cameras.size());
  if (lockstep) {
    const std::string failure = run_lockstep(bus, service, scenario.vision.rate);
    if (!failure.empty()) {
      spdlog::error("stop: {}", failure);
      return config::kFailedWhileRunning;
    }
  } else {
    run_realtime(bus, service);
  }
  spdlog::info("stop exposures={} dropped_frames={} lost_events={}",
               endpoint.status().counter("exposures").load(),
               endpoint.status().counter("dropped_frames").load(),
               endpoint.status().counter("lost_events").load());
  return config::kStopped;
}

}  // namespace
}  // namespace c3rt::vision

int main(int argc, char** argv) try {
  return c3rt::vision::run(argc, argv);
} catch (const std::exception& error) {
  std::fprintf(stderr, "c3rt-vision: %s\n", error.what());
  return c3rt::config::kCouldNotStart;
}
