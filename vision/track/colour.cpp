#include "vision/track/colour.hpp"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace c3rt::vision {
namespace {

constexpr double kLeastColour = 0.1;  // of full scale, across the grey axis
constexpr double kLeastMargin = 0.1;  // to the colour of another ball
constexpr int kGrey = 6;  // components no farther apart than this have no colour; most of a picture

Eigen::Vector3d across_grey(const Eigen::Vector3d& colour) {
  return colour - Eigen::Vector3d::Constant(colour.mean());
}

}  // namespace

ColourKey::ColourKey(const std::vector<Eigen::Vector3d>& colours, std::size_t own) {
  const Eigen::Vector3d& colour = colours.at(own);
  if (across_grey(colour).norm() < kLeastColour)
    throw std::invalid_argument("colour key: ball " + std::to_string(own) + " is grey");
  const Eigen::Vector3d own_direction = across_grey(colour).normalized();
  double strongest_other = 0.0;
  std::vector<Eigen::Vector3d> directions;
  for (std::size_t j = 0; j < colours.size(); ++j) {
    if (j == own) continue;
    directions.push_back(across_grey(colours[j]).normalized());
    strongest_other = std::max(strongest_other, directions.back().dot(colour));
  }
  const double margin = own_direction.dot(colour) - strongest_other;
  if (margin < kLeastMargin) {
    throw std::invalid_argument("colour key: ball " + std::to_string(own) +
                                " has the colour of another one");
  }
  const double scale = (colour.maxCoeff() - colour.minCoeff()) / margin;
  own_ = (scale * own_direction).cast<float>();
  for (const Eigen::Vector3d& direction : directions)
    others_.emplace_back((scale * direction).cast<float>());
}

void ColourKey::extract(const cv::Mat& image, cv::Mat& channel) const {
  channel.create(image.size(), CV_8UC1);
  for (int row = 0; row < image.rows; ++row) {
    const auto* pixel = image.ptr<std::uint8_t>(row);
    auto* out = channel.ptr<std::uint8_t>(row);
    for (int column = 0; column < image.cols; ++column, pixel += 3) {
      const int r = pixel[0], g = pixel[1], b = pixel[2];
      if (std::max({r, g, b}) - std::min({r, g, b}) <= kGrey) {
        out[column] = 0;
        continue;
      }
      const Eigen::Vector3f c(pixel[0], pixel[1], pixel[2]);
      float other = 0.0F;
      for (const Eigen::Vector3f& direction : others_) other = std::max(other, direction.dot(c));
      out[column] = static_cast<std::uint8_t>(std::clamp(own_.dot(c) - other + 0.5F, 0.0F, 255.0F));
    }
  }
}

}  // namespace c3rt::vision
