#pragma once
// A sphere seen by a pinhole camera: its outline is an ellipse whose centre is not the image of the
// sphere's centre.
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace c3rt::vision {

/// Pinhole without distortion. In the image u points right, v down; the centre of the top left
/// pixel is (0, 0). Camera frame C: x right, y down, z forward.
struct CameraModel {
  double fx, fy, cx, cy;  // [px]
  int width, height;      // of the full image [px]
  Eigen::Isometry3d X_WC;
};

/// Square pixels, principal point in the middle of the image. @param fovy vertical field of view
/// [rad]
CameraModel centred_camera(int width, int height, double fovy, const Eigen::Isometry3d& X_WC);

/// Rotation of a camera at p_WC that looks at p_W, its image upright (W's z up).
/// @throws std::invalid_argument if it would look straight up or down, or at itself
Eigen::Matrix3d look_at(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& p_W);

/// Pixel <-> direction in C with z = 1.
Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& p_C) noexcept;
Eigen::Vector3d unproject(const CameraModel& camera, const Eigen::Vector2d& pixel) noexcept;

/// Outline of a sphere in the plane z = 1 of C.
struct Outline {
  Eigen::Vector2d centre;
  Eigen::Vector2d major_axis;  // unit; away from the principal point
  double semi_major, semi_minor;
};

/// The rays that touch a sphere with centre p = (t, z) and radius r form a cone; in the plane z = 1
/// it is the ellipse
///
///   centre = t z / (z² − r²)
///   semi minor axis = r / √(z² − r²)
///   semi major axis = r √(|p|² − r²) / (z² − r²)
///
/// Needs z > r. RT: no heap, no lock, no throw.
Outline sphere_outline(const Eigen::Vector3d& p_C, double radius) noexcept;

/// The inverse: the centre of the sphere of known radius whose outline has this centre and this
/// semi minor axis.
///
///   z = r √(1 + 1/b²),   t = centre (z² − r²) / z
///
/// RT: no heap, no lock, no throw.
Eigen::Vector3d sphere_from_outline(const Eigen::Vector2d& centre, double semi_minor,
                                    double radius) noexcept;

/// The same outline as a cone of directions: |direction| = 1, cos of the half angle to every ray
/// that touches.
///
///   dᵢ · direction = cos_half_angle   for every unit ray dᵢ of the outline
///
/// so the cone through measured rays is a linear fit and its axis carries no perspective bias.
struct Cone {
  Eigen::Vector3d direction;
  double cos_half_angle;
};
Cone sphere_cone(const Eigen::Vector3d& p_C, double radius) noexcept;

/// How far a sphere of that radius is whose outline is the cone. [m]
double cone_distance(const Cone& cone, double radius) noexcept;

/// Where the camera's ray hits the horizontal plane z = height of W; nothing if it does not.
std::optional<Eigen::Vector3d> intersect_plane(const CameraModel& camera,
                                               const Eigen::Vector3d& direction_C,
                                               double height) noexcept;

}  // namespace c3rt::vision
