#include "vision/track/colour.hpp"

#include <stdexcept>

#include <catch2/catch.hpp>

using c3rt::vision::ColourKey;

namespace {

const std::vector<Eigen::Vector3d> kColours = {
    {1.0, 0.36, 0.06}, {0.05, 0.35, 0.95}, {0.1, 0.75, 0.15}, {0.85, 0.1, 0.75}};

int value(const ColourKey& key, const Eigen::Vector3d& colour) {
  cv::Mat image(1, 1, CV_8UC3), channel;
  for (int c = 0; c < 3; ++c)
    image.at<cv::Vec3b>(0, 0)[c] = cv::saturate_cast<std::uint8_t>(255 * colour[c]);
  key.extract(image, channel);
  return channel.at<std::uint8_t>(0, 0);
}

}  // namespace

TEST_CASE("colour key: only the ball's own colour is bright, in full light and in shade") {
  for (std::size_t own = 0; own < kColours.size(); ++own) {
    const ColourKey key(kColours, own);
    for (const double light : {1.0, 0.5}) {
      const double full = kColours[own].maxCoeff() - kColours[own].minCoeff();
      CHECK(value(key, light * kColours[own]) == Approx(255 * light * full).margin(3));
      for (std::size_t other = 0; other < kColours.size(); ++other) {
        if (other != own) CHECK(value(key, light * kColours[other]) == 0);
      }
      for (const double grey : {0.1, 0.5, 0.9})
        CHECK(value(key, Eigen::Vector3d::Constant(light * grey)) <= 2);
    }
  }
}

TEST_CASE("colour key: a pixel that the ball covers by half has half the value") {
  for (std::size_t own = 0; own < kColours.size(); ++own) {
    const ColourKey key(kColours, own);
    const Eigen::Vector3d table = Eigen::Vector3d::Constant(0.7);
    CHECK(value(key, 0.5 * kColours[own] + 0.5 * table) ==
          Approx(0.5 * value(key, kColours[own])).margin(3));
  }
}

TEST_CASE("colour key: a grey ball and two balls of one colour are refused") {
  CHECK_THROWS_AS(ColourKey({{0.5, 0.5, 0.52}}, 0), std::invalid_argument);
  CHECK_THROWS_AS(ColourKey({kColours[0], 0.9 * kColours[0]}, 0), std::invalid_argument);
}
