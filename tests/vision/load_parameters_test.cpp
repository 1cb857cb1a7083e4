#include "vision/load_parameters.hpp"

#include <string>

#include <catch2/catch.hpp>

using namespace c3rt;

namespace {

const std::string kGood = R"(
source: cameras
rate_hz: 80
emulated: {noise_m: 0.001, clip_m: 0.01}
filter: {position_weight: 0.8, velocity_weight: 0.3, velocity_filter: two_tap, lost_after_s: 0.2, gate_m: 0.03, gate_misses: 3}
fusion: {outlier_m: 0.006}
detector:
  roi_px: 80
  search_binning: 2
  blur_px: 1
  hough_resolution_px: 1
  hough_edge: 60
  hough_votes: 8
  radius_tolerance: 0.25
  search_radius_tolerance: 0.4
  rays: 72
  edge_contrast: 12
  inlier_px: 0.7
  visible: 0.4
  position: plane
pixel_noise: 0
cameras:
  - {name: left, position_m: [0.55, 0.7, 0.7], look_at_m: [0.55, 0, 0.03], fovy_rad: 0.8, width_px: 640, height_px: 480}
)";

vision::Parameters load(const std::string& text) {
  return vision::load_parameters(config::Document::parse(text, "test.yaml"));
}

std::string replaced(const std::string& from, const std::string& to) {
  std::string text = kGood;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("vision parameters: accelerations are learnt where the section says how") {
  CHECK_FALSE(load(kGood).acceleration_filter);
  const std::string keys =
      "{noise_m: 5e-4, memory_s: 5, limit_m_per_s2: 0.3, gap_m: 0.003, settle_s: 0.05}";
  const vision::Parameters p = load(kGood + "acceleration_filter: " + keys + "\n");
  REQUIRE(p.acceleration_filter);
  CHECK(p.acceleration_filter->noise == 5e-4);
  CHECK(p.acceleration_filter->settle == 0.05);
  CHECK_THROWS(load(kGood + "acceleration_filter: {noise_m: 5e-4}\n"));
}

TEST_CASE("vision parameters: a complete section is read, and its camera looks where it is told") {
  const vision::Parameters p = load(kGood);
  REQUIRE(p.source == vision::SourceKind::kCameras);
  REQUIRE(p.rate == 80);
  REQUIRE(p.estimator.position_weight == 0.8);
  REQUIRE(p.estimator.velocity_filter == vision::VelocityFilter::kTwoTap);
  REQUIRE(p.detector.rays == 72);
  REQUIRE(p.cameras.size() == 1);
  const Eigen::Vector3d forward = p.cameras[0].R_WC.col(2);
  REQUIRE((forward - Eigen::Vector3d(0, -0.7, -0.67).normalized()).norm() < 1e-12);
}

TEST_CASE("vision parameters: mistakes are refused by key") {
  REQUIRE_THROWS_WITH(load(replaced("noise_m: 0.001", "noise: 0.001")), Catch::Contains("noise"));
  REQUIRE_THROWS_WITH(load(replaced("source: cameras", "source: camera")),
                      Catch::Contains("source"));
  REQUIRE_THROWS_WITH(load(replaced("position_weight: 0.8", "position_weight: 1.8")),
                      Catch::Contains("position_weight"));
  REQUIRE_THROWS_WITH(load(replaced("width_px: 640", "width_px: 64")), Catch::Contains("roi_px"));
  REQUIRE_THROWS_WITH(load(replaced("look_at_m: [0.55, 0, 0.03]", "look_at_m: [0.55, 0.7, 0]")),
                      Catch::Contains("look_at_m"));
  REQUIRE_THROWS_WITH(load(kGood + "shutter_s: 1\n"), Catch::Contains("shutter_s"));
}

TEST_CASE("vision parameters: balls have distinct colours unless the scenario says otherwise") {
  REQUIRE(load(kGood).colours == vision::ObjectColours::kDistinct);
  REQUIRE(load(kGood + "object_colours: same\n").colours == vision::ObjectColours::kSame);
  REQUIRE_THROWS_WITH(load(kGood + "object_colours: red\n"), Catch::Contains("object_colours"));
}

TEST_CASE("vision parameters: errors of the emulated source that drift and come late") {
  const vision::EmulatedParameters none = load(kGood).emulated;
  CHECK(none.drift == 0.0);
  CHECK(none.angle_drift == 0.0);
  CHECK(none.delay == 0.0);
  const vision::EmulatedParameters all =
      load(replaced("clip_m: 0.01",
                    "clip_m: 0.01, drift_m: 0.002, angle_drift_rad: 0.01, "
                    "drift_time_s: 2, delay_s: 0.05"))
          .emulated;
  CHECK(all.drift == 0.002);
  CHECK(all.angle_drift == 0.01);
  CHECK(all.drift_time == 2.0);
  CHECK(all.delay == 0.05);
  REQUIRE_THROWS_WITH(load(replaced("clip_m: 0.01", "clip_m: 0.01, drift_m: 0.002")),
                      Catch::Contains("drift_time_s"));
}

TEST_CASE("vision parameters: only the emulated source can do without cameras") {
  const std::string without = kGood.substr(0, kGood.find("cameras:\n")) + "cameras: []\n";
  REQUIRE_THROWS_WITH(load(without), Catch::Contains("cameras"));
  std::string emulated = without;
  emulated.replace(emulated.find("source: cameras"), 15, "source: emulated");
  REQUIRE(load(emulated).cameras.empty());
}

TEST_CASE("vision parameters: tags and what the cameras' places are off") {
  CHECK_FALSE(load(kGood).tags);
  CHECK(load(kGood).calibration_error.position == 0.0);
  const std::string tags =
      "tags: {margin_px: 30, region_px: 320, corner_noise_px: 0.5, inlier_px: 3, speed_m_per_s: "
      "0.1, "
      "angular_speed_rad_per_s: 1, memory_s: 0.2, gate: 8, gate_misses: 3, lost_after_s: 0.5}\n";
  const vision::Parameters p =
      load(kGood + tags + "calibration_error: {position_m: 0.001, angle_rad: 0.002}\n");
  REQUIRE(p.tags);
  CHECK(p.tags->region == 320);
  CHECK(p.tags->fit.inlier == 3.0);
  CHECK(p.tags->filter.lost_after == 0.5);
  CHECK(p.calibration_error.position == 0.001);
  CHECK(p.calibration_error.angle == 0.002);
  std::string large = tags;
  large.replace(large.find("region_px: 320"), 14, "region_px: 500");
  CHECK_THROWS_WITH(load(kGood + large), Catch::Contains("tags.region_px"));
  CHECK_THROWS_WITH(load(kGood + "tags: {margin_px: 30}\n"), Catch::Contains("missing"));
  CHECK_THROWS_WITH(load(kGood + "calibration_error: {position_m: 0.001}\n"),
                    Catch::Contains("angle_rad"));
}
