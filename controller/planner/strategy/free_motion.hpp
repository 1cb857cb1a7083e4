#pragma once
// The end effector's way between the places where it pushes, past all bodies.
#include <limits>

#include <Eigen/Geometry>

#include "controller/planner/strategy/approach.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

struct FreeMotionParameters {
  double speed;         // [m/s]
  double acceleration;  // of the reference [m/s²]
  double clear;         // from every body, on the way [m]
  double leash;         // the reference waits for an arm that is farther behind than this [m]
  bool over = true;     // bodies are passed above, else beside
  // and then the end effector stays within this, in W [m]
  Eigen::AlignedBox2d reach = {Eigen::Vector2d::Constant(-std::numeric_limits<double>::max()),
                               Eigen::Vector2d::Constant(std::numeric_limits<double>::max())};
};

/// Whether the end effector keeps clear of all bodies on a straight line. Where it begins nearer,
/// it has to come away from them as it moves.
bool line_is_free(const scene::Scene& scene, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                  double clear) noexcept;

/// Where to go next, in a straight line: to the goal, if that line is free; else to above it, on
/// the height that is safe; else up; else off the body that is too near.
/// @param safe height in W [m]
Eigen::Vector3d next_corner(const scene::Scene& scene, const Eigen::Vector3d& from,
                            const Eigen::Vector3d& goal, double safe, double clear) noexcept;

/// Of a way: where it goes in a straight line, and how long all of it is.
struct Leg {
  Eigen::Vector3d corner;
  double left;  // [m]
};

/// The shortest way to the goal, on its height, past all bodies and within reach; where there is
/// none: off the nearest body, or nowhere.
Leg next_leg_beside(const scene::Scene& scene, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& goal, const FreeMotionParameters& parameters) noexcept;

/// A reference whose velocity has no jumps, from corner to corner. While the robot does not follow
/// it rests where the arm is, and it waits for one that stays behind.
class FreeMotion {
 public:
  explicit FreeMotion(const FreeMotionParameters& parameters) : parameters_(parameters) {}

  /// Anew from here.
  void begin(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& v_WE) noexcept;
  /// The goal and all bodies have moved by this.
  void carry(const Eigen::Vector3d& moved) noexcept { reference_ += moved; }
  /// One period.
  void step(const ApproachInput& input, const scene::Scene& scene, const Eigen::Vector3d& goal,
            double safe) noexcept;

  bool there() const noexcept { return there_; }      // the reference is at the goal, at rest
  bool blocked() const noexcept { return blocked_; }  // there is no way beside the bodies
  const Eigen::Vector3d& reference() const noexcept { return reference_; }  // in W [m]
  const Eigen::Vector3d& velocity() const noexcept { return velocity_; }    // of it [m/s]

 private:
  void advance(double period, const scene::Scene& scene, const Eigen::Vector3d& goal,
               double safe) noexcept;

  FreeMotionParameters parameters_;
  bool there_ = false, blocked_ = false;
  Eigen::Vector3d reference_ = Eigen::Vector3d::Zero(), velocity_ = Eigen::Vector3d::Zero();
};

}  // namespace c3rt::planner
