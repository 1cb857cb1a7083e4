#pragma once
// A rigid body as it is described: what planner and plant need to know of it beside its pose.
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/scene/shape.hpp"

namespace c3rt::scene {

/// A square mark of the family tag36h11 on a surface, by which cameras know where the object is.
struct Tag {
  static constexpr int kKinds = 587;  // of the family: ids 0 to 586
  int id = 0;
  double size = 0.0;     // edge of the black square [m]
  Eigen::Vector3d p_BT;  // its middle, on the surface [m]
  Eigen::Matrix3d R_BT;  // x to the right and y up as one reads it, z out of the surface
};

/// Its frame B has the axes of its description and its origin in the centre of mass.
struct Object {
  std::string name;
  double mass = 0.0;                                      // [kg]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  // about its frame [kg m²]
  double friction = 0.0;                                  // μ of its surface, of the roughest part
  std::shared_ptr<const Union> parts;                     // at least one
  std::vector<Tag> tags = {};                             // each id once

  /// Valid as long as the parts.
  Shape shape() const noexcept;
};

Object make_object(std::string name, double mass, const Eigen::Matrix3d& inertia, double friction,
                   Union parts);

/// The same of another mass and size, of one density in itself as before; its tags grow with it.
Object scaled(const Object& object, double mass, double size);

/// One shape of even density. @throws std::invalid_argument for a convex mesh or a union, whose
/// inertia is not known here
Object solid(std::string name, const Shape& shape, double mass, double friction = 1.0);

/// How far along a direction a shape reaches from the origin of its frame [m]. A direction of
/// length 1 in that frame.
double reach(const Shape& shape, const Eigen::Vector3d& direction) noexcept;

}  // namespace c3rt::scene
