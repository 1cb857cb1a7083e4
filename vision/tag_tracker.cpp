#include "vision/tag_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "controller/base/words.hpp"

namespace c3rt::vision {
namespace {

using Eigen::Isometry3d;

constexpr int kPatience = 20;       // exposures in a row before an outlier is spoken of
constexpr double kSameSize = 0.05;  // of a tag's edge

std::string millimetres(double metres) { return base::words("%.1f mm", 1e3 * metres); }

Isometry3d pose_of(const JointFit& fit) {
  Isometry3d X_WB = Isometry3d::Identity();
  X_WB.linear() = fit.q_WB.toRotationMatrix();
  X_WB.translation() = fit.p_WB;
  return X_WB;
}

}  // namespace

TagTracker::TagTracker(const TagParameters& parameters, int search_binning,
                       std::vector<TaggedObject> objects, std::vector<Camera*> cameras)
    : parameters_(parameters),
      search_binning_(search_binning),
      objects_(std::move(objects)),
      cameras_(std::move(cameras)),
      sightings_(objects_.size()) {
  for (const Camera* camera : cameras_) models_.push_back(camera->model());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i].tags.empty())
      throw std::invalid_argument("tags: \"" + objects_[i].name + "\" has none");
    for (std::size_t k = 0; k < objects_[i].tags.size(); ++k) {
      const int id = objects_[i].tags[k].id;
      const auto [other, fresh] = owner_.insert({id, {i, k}});
      if (!fresh) {
        throw std::invalid_argument("tags: id " + std::to_string(id) + " is on \"" +
                                    objects_[other->second.first].name + "\" and on \"" +
                                    objects_[i].name + "\"");
      }
    }
  }
}

std::vector<std::string> TagTracker::take_notices() { return std::exchange(notices_, {}); }

void TagTracker::note(const std::string& about, const std::string& sentence) {
  if (noted_.insert(about).second) notices_.push_back(about + " " + sentence);
}

TagTracker::Seen TagTracker::read(std::size_t camera, const Roi& roi) {
  Seen seen(objects_.size());
  cv::cvtColor(image_, grey_, cv::COLOR_RGB2GRAY);
  const std::vector<SeenTag> tags = detector_.detect(grey_);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const int id = tags[i].id;
    const auto owner = owner_.find(id);
    const std::string name = "tag " + std::to_string(id);
    if (owner == owner_.end()) {
      ++counts_.unknown;
      note(name, "is on no object of the scenario: ignored");
      continue;
    }
    // by id, so that the same ones are neighbours
    const bool twice =
        (i > 0 && tags[i - 1].id == id) || (i + 1 < tags.size() && tags[i + 1].id == id);
    if (twice) {
      ++counts_.twice;
      note(name, "is in one image twice: neither is used");
      continue;
    }
    const auto [object, which] = owner->second;
    TagView view{static_cast<int>(camera), objects_[object].tags[which], {}};
    for (std::size_t k = 0; k < 4; ++k)
      view.seen[k] = to_full(roi, tags[i].corners[k].x(), tags[i].corners[k].y());
    seen[object].push_back(view);
  }
  return seen;
}

std::optional<Roi> TagTracker::region(std::size_t camera, std::size_t object,
                                      const Isometry3d& X_WB) const {
  const CameraModel& model = models_[camera];
  const Isometry3d X_CB = model.X_WC.inverse() * X_WB;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (const scene::Tag& tag : objects_[object].tags) {
    for (const Eigen::Vector3d& corner : tag_corners(tag)) {
      const Eigen::Vector3d p_C = X_CB * corner;
      if (!(p_C.z() > 0.01)) return std::nullopt;
      const Eigen::Vector2d at = project(model, p_C);
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
  }
  // the middle of it where it is too large
  const Eigen::Vector2d middle = 0.5 * (low + high);
  const Eigen::Vector2d half =
      (0.5 * (high - low).array() + parameters_.margin).min(0.5 * parameters_.region).matrix();
  const auto cut = [](double from, double to, int end, int& start, int& length) {
    const double first = std::clamp(std::floor(from), 0.0, static_cast<double>(end));
    const double last = std::clamp(std::floor(to), 0.0, static_cast<double>(end));
    start = static_cast<int>(first);
    length = static_cast<int>(last - first);
  };
  Roi roi{0, 0, 0, 0, 1};
  cut(middle.x() - half.x(), middle.x() + half.x(), model.width, roi.x, roi.width);
  cut(middle.y() - half.y(), middle.y() + half.y(), model.height, roi.y, roi.height);
  constexpr int kLeast = 8;  // [px]
  if (roi.width < kLeast || roi.height < kLeast) return std::nullopt;
  return roi;
}

void TagTracker::look_around(std::size_t object, std::int64_t exposure_ns,
                             const Isometry3d& expected) {
  TagSighting& sighting = sightings_[object];
  std::vector<TagView> views;
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    View& view = sighting.views[camera];
    view = View{};
    // outside its picture nothing is asked of the camera
    const std::optional<Roi> roi = region(camera, object, expected);
    if (!roi) continue;
    view.frame = cameras_[camera]->grab(exposure_ns, *roi, image_);
    if (!view.frame) continue;
    const std::vector<TagView> seen = read(camera, *roi)[object];
    view.detection.found = !seen.empty();
    view.detection.visible =
        static_cast<double>(seen.size()) / static_cast<double>(objects_[object].tags.size());
    views.insert(views.end(), seen.begin(), seen.end());
  }
  sighting.fit = fit_pose(models_, views, expected, parameters_.fit);
  sighting.cameras_used = 0;
  if (!sighting.fit.found) return;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (sighting.fit.used[i]) sighting.views[static_cast<std::size_t>(views[i].camera)].used = true;
  }
  const Isometry3d X_WB = pose_of(sighting.fit);
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    View& view = sighting.views[camera];
    if (view.used) ++sighting.cameras_used;
    view.detection.p_WB = sighting.fit.p_WB;
    view.detection.centre =
        project(models_[camera], models_[camera].X_WC.inverse() * X_WB.translation());
  }
  note_outliers(object, views);
}

void TagTracker::note_outliers(std::size_t object, const std::vector<TagView>& views) {
  const JointFit& fit = sightings_[object].fit;
  std::map<int, std::pair<int, std::size_t>> by_id;  // views that used it, and one that did not
  for (std::size_t i = 0; i < views.size(); ++i) {
    auto& [used, view] = by_id.insert({views[i].tag.id, {0, i}}).first->second;
    if (fit.used[i]) ++used;
    if (!fit.used[i]) {
      ++counts_.outliers;
      view = i;
    }
  }
  for (const auto& [id, what] : by_id) {
    int& rejected = rejected_[id];
    rejected = what.first > 0 ? 0 : rejected + 1;
    if (rejected < kPatience) continue;
    const TagView& view = views[what.second];
    const std::optional<double> size =
        seen_size(models_[static_cast<std::size_t>(view.camera)], view, pose_of(fit));
    const bool other_size = size && std::abs(*size - view.tag.size) > kSameSize * view.tag.size;
    note("tag " + std::to_string(id),
         "of \"" + objects_[object].name + "\" is never where its file puts it" +
             (other_size ? ": its edge is " + millimetres(*size) + " where the file says " +
                               millimetres(view.tag.size)
                         : "") +
             ": not used");
  }
}

void TagTracker::search(std::int64_t exposure_ns, const std::vector<Prediction>& predictions) {
  const std::size_t index = next_search_++ % cameras_.size();
  const Roi roi = full_roi(models_[index], search_binning_);
  if (!cameras_[index]->grab(exposure_ns, roi, image_)) {
    for (TagSighting& sighting : sightings_) {
      if (!sighting.fit.found) sighting.views[index].frame = false;
    }
    return;
  }
  const Seen seen = read(index, roi);
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (sightings_[i].fit.found) continue;
    std::optional<Isometry3d> expected;
    if (predictions[i].q_WB) {
      expected = Isometry3d(Eigen::Quaterniond(*predictions[i].q_WB));
      expected->translation() = predictions[i].p_WB;
    }
    const JointFit found = fit_pose(models_, seen[i], expected, parameters_.fit);
    if (found.found) look_around(i, exposure_ns, pose_of(found));
  }
}

const std::vector<TagSighting>& TagTracker::observe(std::int64_t exposure_ns,
                                                    const std::vector<Prediction>& predictions) {
  bool missing = false;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    sightings_[i] = TagSighting{};
    sightings_[i].views.resize(cameras_.size());
    const Prediction& prediction = predictions[i];
    if (prediction.known && prediction.q_WB) {
      Isometry3d expected(Eigen::Quaterniond(*prediction.q_WB));
      expected.translation() = prediction.p_WB;
      look_around(i, exposure_ns, expected);
    }
    missing = missing || !sightings_[i].fit.found;
  }
  // one full image per exposure: it costs more time than all regions together
  if (missing && !cameras_.empty()) search(exposure_ns, predictions);
  return sightings_;
}

}  // namespace c3rt::vision
