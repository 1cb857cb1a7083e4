#pragma once
// Places about a body where the end effector could begin to push.
#include <limits>
#include <optional>

#include "controller/base/random.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

/// What a place has to be.
struct SampleRules {
  double height;              // of the end effector, in W [m]
  double clearance;           // from the body's surface [m]
  double column;              // the way straight down to it is free by this [m]
  double top;                 // where that way begins, in W [m]
  Eigen::AlignedBox2d reach;  // of the end effector, in W [m]
  // and how far from the robot's base: a stretched arm turns its joints fast for a short way [m]
  double reach_radius = std::numeric_limits<double>::infinity();
  // How the body is wanted to move: along x and y of W [m], and about z by an angle times
  // `radian` [m]. What a push does for that decides how often its place is drawn; zero: all alike.
  Eigen::Vector3d wanted = Eigen::Vector3d::Zero();
  double radian = 0.0;  // a radian counts as this [m]
};

/// Of a normal along the table: one that looks further up or down moves nothing.
constexpr double kLeastAlongTable = 0.3;

/// From the nearest body to the end effector, if it were at this place.
scene::Gap nearest_gap(const scene::Scene& scene, const Eigen::Vector3d& p_WE) noexcept;

/// How far a body reaches from its origin in a direction of W: an upper bound that is millimetres
/// from the truth [m].
double extent(const scene::Body& body, const Eigen::Vector3d& direction) noexcept;

/// The top of the highest body, in W [m].
double top_of(const scene::Scene& scene) noexcept;

/// Whether the end effector can come straight down to a place.
bool column_is_free(const scene::Scene& scene, const SampleRules& rules,
                    const Eigen::Vector3d& place) noexcept;

/// A random point about the body, moved to the clearance of its surface. Points all over the disc
/// that holds the body fall on its faces rather than on its corners, and those are taken more often
/// from which a push moves it as it is wanted. None if no point of a few tries can be used.
std::optional<Eigen::Vector3d> surface_sample(const scene::Scene& scene, int body,
                                              const SampleRules& rules,
                                              base::Random& random) noexcept;

}  // namespace c3rt::planner
