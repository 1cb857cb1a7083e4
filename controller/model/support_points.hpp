#pragma once
// The points on which an object lies on a table.
#include <vector>

#include <Eigen/Core>

#include "controller/scene/object.hpp"

namespace c3rt::model {

/// For each face of an object's convex hull, a few points that are spread over it. Which points a
/// face has is chosen once, so that the contacts of a model are the same ones from step to step.
class SupportPoints {
 public:
  /// Where the surface is round it is this far from the point, whatever way down is.
  struct Point {
    Eigen::Vector3d p_B;  // in the body's frame [m]
    double radius;        // [m]
  };

  /// @param count of each face, 3 or 4
  /// @throws std::invalid_argument for another count
  SupportPoints(const scene::Object& object, int count);

  /// So many for every face: `count`, or fewer where the object has no more.
  int size() const noexcept { return size_; }
  /// Those of the face that looks down the most.
  /// @param R_WB the body's axes in W
  const std::vector<Point>& below(const Eigen::Matrix3d& R_WB) const noexcept;

 private:
  struct Face {
    Eigen::Vector3d normal;  // outwards, in the body's frame
    std::vector<Point> points;
  };

  int size_;
  std::vector<Face> faces_;
};

}  // namespace c3rt::model
