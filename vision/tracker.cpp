#include "vision/tracker.hpp"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "vision/track/assign.hpp"

namespace c3rt::vision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFarthest = 10.0;       // a lost sphere may be anywhere within this [m]
constexpr double kOverlap = 0.8;         // of the sum of the radii: closer centres are impossible
constexpr std::size_t kMostNearby = 3;   // circles that one region of interest may give
constexpr std::size_t kMostInImage = 8;  // circles that a full image may give

DetectorParameters for_search(DetectorParameters parameters) {
  parameters.radius_tolerance = parameters.search_radius_tolerance;
  return parameters;
}

/// A circle, and the only sphere that it can be; -1: any.
struct Candidate {
  Detection detection;
  int only;
};

/// To each sphere that is expected somewhere its candidate, −1: none, so that the sum of their
/// distances is the least.
/// @param units  of each sphere's distance [m]; `gate` is in them
std::vector<int> nearest(const std::vector<Candidate>& candidates,
                         const std::vector<std::optional<Eigen::Vector3d>>& expected,
                         const std::vector<double>& units, double gate) {
  const auto rows = static_cast<Eigen::Index>(expected.size());
  Eigen::MatrixXd cost =
      Eigen::MatrixXd::Constant(rows, static_cast<Eigen::Index>(candidates.size()), kInfinity);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto sphere = static_cast<std::size_t>(i);
    if (!expected[sphere]) continue;
    for (Eigen::Index j = 0; j < cost.cols(); ++j) {
      const Candidate& candidate = candidates[static_cast<std::size_t>(j)];
      if (candidate.only < 0 || candidate.only == i)
        cost(i, j) = (candidate.detection.p_WB - *expected[sphere]).norm() / units[sphere];
    }
  }
  return assign(cost, gate);
}

double total_visible(const Sighting& sighting) {
  double sum = 0.0;
  for (const View& view : sighting.views) sum += view.used ? view.detection.visible : 0.0;
  return sum;
}

}  // namespace

Tracker::Tracker(const Parameters& parameters, std::vector<SphereModel> spheres,
                 std::vector<Camera*> cameras)
    : parameters_(parameters),
      spheres_(std::move(spheres)),
      cameras_(std::move(cameras)),
      tracking_(parameters.detector),
      searching_(for_search(parameters.detector)),
      sightings_(spheres_.size()) {
  if (parameters.colours == ObjectColours::kSame || spheres_.size() < 2) return;
  std::vector<Eigen::Vector3d> colours;
  for (const SphereModel& sphere : spheres_) colours.push_back(sphere.colour);
  for (std::size_t i = 0; i < spheres_.size(); ++i) keys_.emplace_back(colours, i);
}

Expectation Tracker::expectation(std::size_t index, const Eigen::Vector3d& p_WB) const {
  return {p_WB, spheres_[index].radius, spheres_[index].height};
}

std::vector<Detection> Tracker::detect(CircleDetector& detector, const CameraModel& model,
                                       std::size_t sphere, const Roi& roi,
                                       const Expectation& expected, std::size_t most) {
  // where only one sphere can be seen, the first good circle is it
  if (spheres_.size() > 1 && keys_.empty())
    return detector.detect_all(model, image_, roi, expected, most);
  if (!keys_.empty()) keys_[sphere].extract(image_, channel_);
  const Detection detection =
      detector.detect(model, keys_.empty() ? image_ : channel_, roi, expected);
  if (!detection.found) return {};
  return {detection};
}

void Tracker::look_with(std::size_t camera, std::int64_t exposure_ns, const Places& places,
                        const std::vector<bool>& wanted) {
  const CameraModel& model = cameras_[camera]->model();
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (!wanted[i] || !places[i]) continue;
    View& view = sightings_[i].views[camera];
    view = View{};
    const Expectation expected = expectation(i, *places[i]);
    Roi roi;
    // outside its picture nothing is asked of the camera
    if (!roi_around(model, expected, parameters_.detector.roi, roi)) continue;
    view.frame = cameras_[camera]->grab(exposure_ns, roi, image_);
    if (!view.frame) continue;
    const std::vector<Detection> seen = detect(tracking_, model, i, roi, expected, kMostNearby);
    for (const Detection& detection : seen) {
      // neighbours of one colour are in each other's regions
      const bool twice =
          keys_.empty() &&
          std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
            return (other.detection.p_WB - detection.p_WB).norm() < spheres_[i].radius;
          });
      if (!twice) candidates.push_back({detection, keys_.empty() ? -1 : static_cast<int>(i)});
    }
  }

  std::vector<double> radii;
  for (const SphereModel& sphere : spheres_) radii.push_back(sphere.radius);
  // in radii, so that 1 is the gate of every sphere
  const std::vector<int> columns = nearest(candidates, places, radii, 1.0);
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (wanted[i] && columns[i] >= 0) {
      sightings_[i].views[camera].detection =
          candidates[static_cast<std::size_t>(columns[i])].detection;
    }
  }
}

void Tracker::look_around(std::int64_t exposure_ns, const Places& places,
                          const std::vector<bool>& wanted) {
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera)
    look_with(camera, exposure_ns, places, wanted);
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (!wanted[i] || !places[i]) continue;
    Sighting& sighting = sightings_[i];
    std::vector<CameraEstimate> estimates;
    for (const View& view : sighting.views)
      estimates.push_back({view.detection.found, view.detection.p_WB});
    sighting.fusion = fuse(estimates, *places[i], parameters_.fusion);
    std::vector<Ray> rays;
    for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
      View& view = sighting.views[camera];
      view.used = sighting.fusion.used[camera];
      const Eigen::Vector3d origin = cameras_[camera]->model().X_WC.translation();
      if (view.used) rays.push_back({origin, (view.detection.p_WB - origin).normalized()});
    }
    if (parameters_.fusion.rays && rays.size() > 1) sighting.fusion.p_WB = meeting_point(rays);
  }
}

Tracker::Places Tracker::search(std::int64_t exposure_ns,
                                const std::vector<Prediction>& predictions) {
  Places places(spheres_.size());
  const std::size_t index = next_search_++ % cameras_.size();
  Camera& camera = *cameras_[index];
  const Roi roi = full_roi(camera.model(), parameters_.detector.search_binning);
  searched_ = true;
  if (!camera.grab(exposure_ns, roi, image_)) {
    for (Sighting& sighting : sightings_) {
      if (!sighting.fusion.found) sighting.views[index].frame = false;
    }
    return places;
  }
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (sightings_[i].fusion.found) continue;
    const std::vector<Detection> seen = detect(searching_, camera.model(), i, roi,
                                               expectation(i, predictions[i].p_WB), kMostInImage);
    for (const Detection& detection : seen)
      candidates.push_back({detection, keys_.empty() ? -1 : static_cast<int>(i)});
    if (keys_.empty()) break;  // the same circles for all
  }
  // what another sphere explains is not the missing one
  const auto explained = [&](const Candidate& candidate) {
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      const bool blocks = candidate.only < 0 && sightings_[i].fusion.found;
      const double distance = (sightings_[i].fusion.p_WB - candidate.detection.p_WB).norm();
      if (blocks && distance < 2.0 * kOverlap * spheres_[i].radius) return true;
    }
    return false;
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), explained),
                   candidates.end());
  Places expected(spheres_.size());
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (!sightings_[i].fusion.found) expected[i] = predictions[i].p_WB;
  }
  const std::vector<int> columns =
      nearest(candidates, expected, std::vector<double>(spheres_.size(), 1.0), kFarthest);
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (columns[i] >= 0)
      places[i] = candidates[static_cast<std::size_t>(columns[i])].detection.p_WB;
  }
  return places;
}

void Tracker::drop_impossible(const std::vector<Prediction>& predictions) {
  // spheres are not inside each other: of two in one place, the better seen one is there
  const auto merit = [&](std::size_t i) {
    const Sighting& s = sightings_[i];
    return std::make_tuple(s.fusion.cameras_used, total_visible(s),
                           -(s.fusion.p_WB - predictions[i].p_WB).norm());
  };
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!sightings_[i].fusion.found || !sightings_[j].fusion.found) continue;
      const double distance = (sightings_[i].fusion.p_WB - sightings_[j].fusion.p_WB).norm();
      if (distance >= kOverlap * (spheres_[i].radius + spheres_[j].radius)) continue;
      Sighting& worse = sightings_[merit(i) > merit(j) ? j : i];
      worse.fusion.found = false;
      worse.fusion.cameras_used = 0;
      for (View& view : worse.views) view.used = false;
    }
  }
}

const std::vector<Sighting>& Tracker::observe(std::int64_t exposure_ns,
                                              const std::vector<Prediction>& predictions) {
  searched_ = false;
  Places places(spheres_.size());
  std::vector<bool> wanted(spheres_.size());
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    sightings_[i] = Sighting{};
    sightings_[i].views.resize(cameras_.size());
    wanted[i] = predictions[i].known;
    if (wanted[i]) places[i] = predictions[i].p_WB;
  }
  look_around(exposure_ns, places, wanted);
  drop_impossible(predictions);

  for (std::size_t i = 0; i < spheres_.size(); ++i) wanted[i] = !sightings_[i].fusion.found;
  const bool any_missing = std::find(wanted.begin(), wanted.end(), true) != wanted.end();
  if (!any_missing || cameras_.empty()) return sightings_;
  // one full image per exposure: it costs as much time as all regions of interest together
  places = search(exposure_ns, predictions);
  bool any_place = false;
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (wanted[i]) any_place = any_place || places[i].has_value();
    if (!wanted[i]) places[i] = sightings_[i].fusion.p_WB;
  }
  if (!any_place) return sightings_;
  look_around(exposure_ns, places, wanted);
  drop_impossible(predictions);
  return sightings_;
}

}  // namespace c3rt::vision
