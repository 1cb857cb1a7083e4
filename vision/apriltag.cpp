#include "vision/apriltag.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include "controller/scene/object.hpp"

namespace c3rt::vision {
namespace {

struct FamilyDeleter {
  void operator()(apriltag_family_t* family) const noexcept { tag36h11_destroy(family); }
};
struct DetectorDeleter {
  void operator()(apriltag_detector_t* detector) const noexcept {
    apriltag_detector_destroy(detector);
  }
};
struct DetectionsDeleter {
  void operator()(zarray_t* detections) const noexcept { apriltag_detections_destroy(detections); }
};
struct ImageDeleter {
  void operator()(image_u8_t* image) const noexcept { image_u8_destroy(image); }
};
using Family = std::unique_ptr<apriltag_family_t, FamilyDeleter>;

Family make_family() {
  Family family(tag36h11_create());
  if (family->ncodes != static_cast<std::uint32_t>(scene::Tag::kKinds))
    throw std::logic_error("apriltag: tag36h11 has " + std::to_string(family->ncodes) + " tags");
  return family;
}

// It counts from the corner of the top left pixel.
constexpr double kPixelCentre = 0.5;

}  // namespace

struct TagDetector::Implementation {
  Implementation() : family(make_family()), detector(apriltag_detector_create()) {
    // of two wrong bits in 36, two more tags are never nearer than nine
    apriltag_detector_add_family_bits(detector.get(), family.get(), 2);
    detector->nthreads = 1;
    // of all pixels: tags on what an arm pushes are small
    detector->quad_decimate = 1.0F;
    // what differs less is noise on one colour, not black on white
    detector->qtp.min_white_black_diff = 30;
  }

  Family family;
  std::unique_ptr<apriltag_detector_t, DetectorDeleter> detector;
};

TagDetector::TagDetector() : implementation_(std::make_unique<Implementation>()) {}
TagDetector::~TagDetector() = default;

std::vector<SeenTag> TagDetector::detect(const cv::Mat& grey) {
  if (grey.type() != CV_8UC1) throw std::invalid_argument("tag detector: expected a grey image");
  image_u8_t image{grey.cols, grey.rows, static_cast<std::int32_t>(grey.step[0]), grey.data};
  const std::unique_ptr<zarray_t, DetectionsDeleter> found(
      apriltag_detector_detect(implementation_->detector.get(), &image));
  std::vector<SeenTag> seen;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found.get(), i, &detection);
    SeenTag tag;
    tag.id = detection->id;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      tag.corners[corner] << detection->p[corner][0] - kPixelCentre,
          detection->p[corner][1] - kPixelCentre;
    }
    seen.push_back(tag);
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [](const SeenTag& a, const SeenTag& b) { return a.id < b.id; });
  return seen;
}

plant::TagPicture tag_picture(int id) {
  if (id < 0 || id >= scene::Tag::kKinds) {
    throw std::invalid_argument("tag picture: expected an id of 0 to " +
                                std::to_string(scene::Tag::kKinds - 1) + ", got " +
                                std::to_string(id));
  }
  const Family family = make_family();
  const std::unique_ptr<image_u8_t, ImageDeleter> image(apriltag_to_image(family.get(), id));
  plant::TagPicture picture;
  picture.id = id;
  picture.side = image->width;
  picture.border = (family->total_width - family->width_at_border) / 2;
  for (int row = 0; row < image->height; ++row) {
    const std::uint8_t* cells = image->buf + static_cast<std::ptrdiff_t>(row) * image->stride;
    picture.cells.insert(picture.cells.end(), cells, cells + image->width);
  }
  return picture;
}

}  // namespace c3rt::vision
