#pragma once
// The end effector brings a rolling sphere to rest, and leaves it lying still.
#include <optional>

#include <Eigen/Core>

#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

/// What a period begins with.
struct RestInput {
  double now;                           // session time [s]
  double period;                        // since the last call [s]
  Eigen::Vector3d p_WE, v_WE;           // the end effector [m, m/s]
  bool seen;                            // what follows is of now, else of when it was last seen
  double radius;                        // of the sphere [m]
  Eigen::Vector3d p_WB, v_WB;           // and where it is [m, m/s]
  std::optional<Eigen::Vector2d> goal;  // where the sphere is to lie, if that matters, in W [m]
};

/// A sphere between the table and an end effector that presses on it rolls at half the end
/// effector's speed: where the end effector comes to rest, the sphere does, whatever the cameras
/// say. So the end effector meets the sphere from above and moves along with it, sinks until it
/// stands on it, brakes, stands still, lets its press fade, and rises slowly, as a sphere that
/// nothing resists keeps the least speed that it is left with. On the sphere the press alone
/// decides the height. A sphere that lies near its goal is rolled there, at half the end effector's
/// way.
class Rest {
 public:
  enum class Stage { kMeet, kTouch, kBrake, kStand, kCarry, kRelease, kRise, kLeft, kFailed };

  /// @param leash the reference waits for an arm that is farther behind [m]
  Rest(double end_effector_radius, double leash);

  /// Anew from here, at the end effector's speed.
  void begin(const RestInput& input) noexcept;
  /// One period.
  void step(const RestInput& input) noexcept;

  Stage stage() const noexcept { return stage_; }
  const Eigen::Vector3d& reference() const noexcept { return reference_; }  // in W [m]
  const Eigen::Vector3d& velocity() const noexcept { return velocity_; }    // of it [m/s]
  double press() const noexcept { return press_; }                          // down [N]

 private:
  void enter(Stage stage, double now) noexcept;
  /// Changes the velocity towards what is wanted, and moves on.
  void advance(const RestInput& input, const Eigen::Vector3d& velocity) noexcept;
  void meet(const RestInput& input) noexcept;
  void touch(const RestInput& input) noexcept;
  void stand(const RestInput& input) noexcept;
  /// Rolls the sphere towards its goal. @return false where it is there, or too far to be carried
  bool carry(const RestInput& input) noexcept;
  double gap(const RestInput& input) const noexcept;

  double end_effector_radius_;
  double leash_;
  Stage stage_ = Stage::kLeft;
  double since_ = 0.0;        // of the stage [s]
  double still_since_ = 0.0;  // of the end effector [s]
  bool from_above_ = false;   // it touched the sphere on its top
  bool stopped_ = false;      // the sphere was at rest once
  double press_ = 0.0;
  Eigen::Vector2d carry_to_ = Eigen::Vector2d::Zero();  // the end effector [m]
  bool carried_ = false;                                // since it touched the sphere
  Eigen::Vector2d v_WB_ = Eigen::Vector2d::Zero();      // smoothed
  Eigen::Vector3d reference_ = Eigen::Vector3d::Zero(), velocity_ = Eigen::Vector3d::Zero();
};

}  // namespace c3rt::planner
