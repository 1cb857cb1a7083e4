#pragma once
// Objects with tags seen by several cameras: where to look, which tag is whose, one pose from all
// corners in all images.
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "vision/apriltag.hpp"
#include "vision/camera.hpp"
#include "vision/parameters.hpp"
#include "vision/tag/joint_fit.hpp"
#include "vision/tracker.hpp"

namespace c3rt::vision {

struct TaggedObject {
  std::string name;
  std::vector<scene::Tag> tags;  // at least one
};

/// One object at one exposure.
struct TagSighting {
  JointFit fit;
  int cameras_used = 0;
  std::vector<View> views;  // by camera
};

/// Of tags in images that were not used, since the start.
struct TagCounts {
  std::uint64_t unknown = 0;   // on no object
  std::uint64_t twice = 0;     // of one id in one image: neither is used
  std::uint64_t outliers = 0;  // not where the pose of their object puts them
};

/// Looks for each object's tags in the region of each camera where they are expected; for those
/// objects that no camera sees there, searches the full image of one camera, another one at each
/// exposure, and then looks again around what was found.
class TagTracker {
 public:
  /// @param cameras  outlive the tracker; asked in this order
  /// @throws std::invalid_argument if an object has no tag, or two tags have one id
  TagTracker(const TagParameters& parameters, int search_binning, std::vector<TaggedObject> objects,
             std::vector<Camera*> cameras);

  /// @param predictions  by object; without an orientation an object is searched
  /// @return by object; valid until the next call
  const std::vector<TagSighting>& observe(std::int64_t exposure_ns,
                                          const std::vector<Prediction>& predictions);

  const TagCounts& counts() const noexcept { return counts_; }
  /// Sentences for a person about tags that cannot be used, each tag once.
  std::vector<std::string> take_notices();

 private:
  using Seen = std::vector<std::vector<TagView>>;  // by object

  /// The tags in image_, which shows that region of that camera, of each object.
  Seen read(std::size_t camera, const Roi& roi);
  void look_around(std::size_t object, std::int64_t exposure_ns, const Eigen::Isometry3d& expected);
  void search(std::int64_t exposure_ns, const std::vector<Prediction>& predictions);
  /// The region of a camera around an object's tags; none outside its picture.
  std::optional<Roi> region(std::size_t camera, std::size_t object,
                            const Eigen::Isometry3d& X_WB) const;
  void note_outliers(std::size_t object, const std::vector<TagView>& views);
  void note(const std::string& about, const std::string& sentence);

  TagParameters parameters_;
  int search_binning_;
  std::vector<TaggedObject> objects_;
  std::vector<Camera*> cameras_;
  std::vector<CameraModel> models_;
  TagDetector detector_;
  std::map<int, std::pair<std::size_t, std::size_t>>
      owner_;  // of an id: object and which tag of it
  std::vector<TagSighting> sightings_;
  std::map<int, int> rejected_;  // by id: exposures in a row
  TagCounts counts_;
  std::set<std::string> noted_;
  std::vector<std::string> notices_;
  std::size_t next_search_ = 0;
  cv::Mat image_, grey_;
};

}  // namespace c3rt::vision
