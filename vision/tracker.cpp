#include "vision/tracker.hpp"

#include <utility>

namespace c3rt::vision {
namespace {

DetectorParameters for_search(DetectorParameters parameters) {
  parameters.radius_tolerance = parameters.search_radius_tolerance;
  return parameters;
}

}  // namespace

Tracker::Tracker(const Parameters& parameters, double ball_radius, double ball_height,
                 std::vector<Camera*> cameras)
    : parameters_(parameters),
      ball_radius_(ball_radius),
      ball_height_(ball_height),
      cameras_(std::move(cameras)),
      tracking_(parameters.detector),
      searching_(for_search(parameters.detector)) {}

Sighting Tracker::look_around(std::int64_t exposure_ns, const Eigen::Vector3d& p_expected) {
  Sighting sighting;
  sighting.views.resize(cameras_.size());
  std::vector<CameraEstimate> estimates(cameras_.size());
  const Expectation expected{p_expected, ball_radius_, ball_height_};
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    View& view = sighting.views[i];
    const CameraModel& model = cameras_[i]->model();
    Roi roi;
    if (!roi_around(model, expected, parameters_.detector.roi, roi)) {
      view.frame = true;  // nothing was asked of it
      continue;
    }
    view.frame = cameras_[i]->grab(exposure_ns, roi, image_);
    if (!view.frame) continue;
    view.detection = tracking_.detect(model, image_, roi, expected);
    estimates[i] = {view.detection.found, view.detection.p_WB};
  }
  sighting.fusion = fuse(estimates, p_expected, parameters_.fusion);
  for (std::size_t i = 0; i < cameras_.size(); ++i)
    sighting.views[i].used = sighting.fusion.used[i];
  return sighting;
}

Sighting Tracker::observe(std::int64_t exposure_ns, const Eigen::Vector3d& p_expected, bool known) {
  Sighting sighting;
  sighting.views.resize(cameras_.size(), View{true, false, {}});
  if (known) {
    sighting = look_around(exposure_ns, p_expected);
    if (sighting.fusion.found) return sighting;
  }
  if (cameras_.empty()) return sighting;

  // one full image per exposure: it costs as much time as all regions of interest together
  const std::size_t index = next_search_++ % cameras_.size();
  Camera& camera = *cameras_[index];
  const Roi roi = full_roi(camera.model(), parameters_.detector.search_binning);
  sighting.searched = true;
  if (!camera.grab(exposure_ns, roi, image_)) {
    sighting.views[index].frame = false;
    return sighting;
  }
  const Detection detection =
      searching_.detect(camera.model(), image_, roi, {p_expected, ball_radius_, ball_height_});
  if (!detection.found) return sighting;
  sighting = look_around(exposure_ns, detection.p_WB);
  sighting.searched = true;
  return sighting;
}

}  // namespace c3rt::vision
