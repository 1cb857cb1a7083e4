// A camera of one's own in C++: pictures from files, the ball found in each, as object/estimate. It
// needs no emulated camera and no truth: what reads the files could read a device.
//
//   cpp_camera FOLDER --clock lockstep &      # 000.pgm, 001.pgm, …: 8 bits, a bright ball
//   c3rt run circle_slow --without vision --clock lockstep
//
// The camera looks straight down: a pixel is a place on the table, from the corner kCorner, x to
// the right and y up.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "idl/client/estimator.hpp"

namespace {

using namespace c3rt::client;

constexpr double kRate = 50.0;  // of the pictures [Hz]
constexpr double kMetresPerPixel = 0.001;
constexpr double kCorner_x = 0.35, kCorner_y = 0.3;  // of the picture's upper left corner, in W [m]
constexpr double kHeight = 0.007;                    // of the ball's centre [m]
constexpr int kBright = 128;                         // a pixel of the ball is brighter
constexpr int kLeastPixels = 50;                     // of a ball

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  // row after row
};

/// Of the format P5 without comments.
Picture read_pgm(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string kind;
  Picture picture;
  int largest = 0;
  stream >> kind >> picture.width >> picture.height >> largest;
  stream.get();
  const bool fits = stream && kind == "P5" && largest == 255 && picture.width > 0 &&
                    picture.height > 0 && picture.width <= 4096 && picture.height <= 4096;
  if (fits) {
    picture.pixels.resize(static_cast<std::size_t>(picture.width) *
                          static_cast<std::size_t>(picture.height));
    stream.read(reinterpret_cast<char*>(picture.pixels.data()),
                static_cast<std::streamsize>(picture.pixels.size()));
  }
  if (!fits || !stream) {
    throw std::runtime_error(file.string() +
                             ": expected a PGM of 8 bits: P5 WIDTH HEIGHT 255 and its pixels");
  }
  return picture;
}

/// A file for each period; after the last one nothing new is seen.
class Files : public Estimator {
 public:
  explicit Files(const std::filesystem::path& folder) : Estimator({kRate, false}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".pgm") files_.push_back(entry.path());
    std::sort(files_.begin(), files_.end());
  }

  std::vector<Estimate> estimate(double, const c3rt::wire::Scene*) override {
    if (next_ == files_.size()) return {};
    const std::filesystem::path& file = files_[next_++];
    const Picture picture = read_pgm(file);
    double column = 0.0, row = 0.0;
    int count = 0;
    auto pixel = picture.pixels.begin();
    for (int i = 0; i < picture.height; ++i) {
      for (int k = 0; k < picture.width; ++k) {
        if (*pixel++ <= kBright) continue;
        column += k;
        row += i;
        ++count;
      }
    }
    if (count < kLeastPixels) {
      say("no ball in " + file.filename().string(), true);
      return {};
    }
    const Vector p{kCorner_x + kMetresPerPixel * (column / count + 0.5),
                   kCorner_y - kMetresPerPixel * (row / count + 0.5), kHeight};
    Estimate seen{0, p};
    for (std::size_t i = 0; last_ && i < p.size(); ++i) seen.v[i] = (p[i] - (*last_)[i]) * kRate;
    last_ = p;
    return {seen};
  }

 private:
  std::vector<std::filesystem::path> files_;
  std::size_t next_ = 0;
  std::optional<Vector> last_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || !std::filesystem::is_directory(argv[1])) {
    std::fprintf(stderr, "%s: error: expected the folder of the pictures first\n", argv[0]);
    return 2;
  }
  return Files(argv[1]).main(argc - 1, argv + 1);
}
