#include "vision/load_parameters.hpp"

namespace c3rt::vision {
namespace {

constexpr int kMaxCameras = 8;

EstimatorParameters load_filter(config::Section section) {
  EstimatorParameters p{};
  p.position_weight = section.number("position_weight", {0.01, 1});
  p.velocity_weight = section.number("velocity_weight", {0.01, 1});
  p.velocity_filter = section.choice<VelocityFilter>("velocity_filter",
                                                     {{"two_tap", VelocityFilter::kTwoTap},
                                                      {"recursive", VelocityFilter::kRecursive},
                                                      {"predicting", VelocityFilter::kPredicting}});
  p.lost_after = section.number("lost_after_s", {0.01, 10});
  p.gate = section.number("gate_m", {0.001, 1});
  p.gate_misses = section.integer("gate_misses", {0, 1000});
  return p;
}

AccelerationFilterParameters load_acceleration_filter(config::Section section) {
  AccelerationFilterParameters p{};
  p.noise = section.number("noise_m", {1e-6, 0.1});
  p.memory = section.number("memory_s", {0.01, 1e4});
  p.limit = section.number("limit_m_per_s2", {1e-3, 10});
  p.gap = section.number("gap_m", {0, 0.1});
  p.settle = section.number("settle_s", {0, 1});
  return p;
}

DetectorParameters load_detector(config::Section section) {
  DetectorParameters p{};
  p.roi = section.integer("roi_px", {16, 512});
  p.search_binning = section.integer("search_binning", {1, 8});
  p.blur = section.number("blur_px", {0.3, 3});
  p.hough_resolution = section.number("hough_resolution_px", {1, 4});
  p.hough_edge = section.number("hough_edge", {1, 255});
  p.hough_votes = section.number("hough_votes", {1, 500});
  p.radius_tolerance = section.number("radius_tolerance", {0.02, 0.6});
  p.search_radius_tolerance = section.number("search_radius_tolerance", {0.02, 0.9});
  p.rays = section.integer("rays", {16, 720});
  p.edge_contrast = section.number("edge_contrast", {1, 255});
  p.inlier = section.number("inlier_px", {0.1, 5});
  p.visible = section.number("visible", {0.1, 1});
  p.position = section.choice<PositionMethod>(
      "position", {{"plane", PositionMethod::kPlane}, {"radius", PositionMethod::kRadius}});
  return p;
}

TagParameters load_tags(config::Section section) {
  TagParameters p{};
  p.margin = section.number("margin_px", {1, 500});
  p.region = section.integer("region_px", {16, 2048});
  p.fit.corner_noise = section.number("corner_noise_px", {0.01, 10});
  p.fit.inlier = section.number("inlier_px", {0.1, 20});
  p.filter.speed = section.number("speed_m_per_s", {1e-3, 10});
  p.filter.angular_speed = section.number("angular_speed_rad_per_s", {1e-3, 100});
  p.filter.memory = section.number("memory_s", {0.01, 100});
  p.filter.gate = section.number("gate", {1, 100});
  p.filter.gate_misses = section.integer("gate_misses", {0, 1000});
  p.filter.lost_after = section.number("lost_after_s", {0.01, 10});
  return p;
}

CameraParameters load_camera(config::Section section) {
  CameraParameters p{};
  p.name = section.name("name");
  p.p_WC = section.numbers("position_m", 3, {-5, 5});
  const Eigen::Vector3d target = section.numbers("look_at_m", 3, {-5, 5});
  if ((target - p.p_WC).head<2>().norm() < 0.01) {
    section.fail("look_at_m", "a point that is not straight above or below position_m",
                 "the same x and y");
  }
  p.R_WC = look_at(p.p_WC, target);
  p.fovy = section.number("fovy_rad", {0.05, 2.5});
  p.width = section.integer("width_px", {32, 2048});
  p.height = section.integer("height_px", {32, 2048});
  return p;
}

}  // namespace

Parameters load_parameters(config::Section section) {
  Parameters p{};
  p.source = section.choice<SourceKind>(
      "source", {{"cameras", SourceKind::kCameras}, {"emulated", SourceKind::kEmulated}});
  p.rate = section.number("rate_hz", {1, 1000});
  const bool cameras = p.source == SourceKind::kCameras;
  const std::string why = cameras ? "source cameras" : "source emulated";
  if (section.given("emulated", !cameras, why)) {
    config::Section emulated = section.section("emulated");
    p.emulated.noise = emulated.number("noise_m", {0, 0.1});
    p.emulated.clip = emulated.number("clip_m", {0, 0.1});
    p.emulated.angle_noise = emulated.number("angle_noise_rad", {0, 1}, 0.0);
    p.emulated.drift = emulated.number("drift_m", {0, 0.1}, 0.0);
    p.emulated.angle_drift = emulated.number("angle_drift_rad", {0, 1}, 0.0);
    const bool drifts = p.emulated.drift > 0 || p.emulated.angle_drift > 0;
    if (emulated.given("drift_time_s", drifts, "an error that drifts"))
      p.emulated.drift_time = emulated.number("drift_time_s", {0.01, 1000});
    p.emulated.delay = emulated.number("delay_s", {0, 1}, 0.0);
  }
  p.estimator = load_filter(section.section("filter"));
  if (section.has("acceleration_filter"))
    p.acceleration_filter = load_acceleration_filter(section.section("acceleration_filter"));
  if (section.given("fusion", cameras, why)) {
    config::Section fusion = section.section("fusion");
    p.fusion.outlier = fusion.number("outlier_m", {1e-4, 1});
    if (fusion.has("rays")) p.fusion.rays = fusion.boolean("rays");
  }
  if (section.given("detector", cameras, why))
    p.detector = load_detector(section.section("detector"));
  if (section.has("tags")) p.tags = load_tags(section.section("tags"));
  p.colours = ObjectColours::kDistinct;
  if (section.has("object_colours")) {
    p.colours = section.choice<ObjectColours>(
        "object_colours", {{"distinct", ObjectColours::kDistinct}, {"same", ObjectColours::kSame}});
  }
  if (section.given("pixel_noise", cameras, why))
    p.pixel_noise = section.number("pixel_noise", {0, 50});
  if (section.has("calibration_error")) {
    config::Section error = section.section("calibration_error");
    p.calibration_error.position = error.number("position_m", {0, 0.1});
    p.calibration_error.angle = error.number("angle_rad", {0, 0.1});
  }
  if (section.given("cameras", cameras, why)) {
    for (config::Section& camera : section.list("cameras", 0, kMaxCameras))
      p.cameras.push_back(load_camera(camera));
  }
  if (cameras && p.cameras.empty()) {
    section.fail("cameras", "at least one camera, because source is cameras", "none");
  }
  for (const CameraParameters& camera : p.cameras) {
    if (p.detector.roi > camera.width || p.detector.roi > camera.height) {
      section.fail("cameras", "images not smaller than detector.roi_px",
                   "a smaller one: " + camera.name);
    }
    if (p.tags && (p.tags->region > camera.width || p.tags->region > camera.height)) {
      section.fail("cameras", "images not smaller than tags.region_px",
                   "a smaller one: " + camera.name);
    }
  }
  section.finish();
  return p;
}

}  // namespace c3rt::vision
