#pragma once
// A motion generator of one's own in the place of c3rt-impedance: a class with one method. The
// robot's own controller follows what it says.
#include <array>
#include <memory>
#include <optional>
#include <variant>

#include "idl/client/motion.hpp"
#include "idl/client/process.hpp"

namespace c3rt::client {

using Joints = std::array<double, 7>;

struct JointPositions {
  Joints q{};             // [rad]
  bool finished = false;  // the last one: the robot is idle again
};

struct JointVelocities {
  Joints dq{};  // [rad/s]
  bool finished = false;
};

struct Elbow {
  double q3 = 0.0;    // of the third joint [rad]
  double sign = 1.0;  // of the fourth one, −1 or 1
};

struct CartesianPose {
  Vector p{};                       // p_WE [m]
  Quaternion q{0, 1, 0, 0};         // q_WE; as it is here, the tool points down
  std::optional<Elbow> elbow = {};  // none: as it comes
  bool finished = false;
};

struct CartesianVelocities {
  Vector v{};      // of the end effector, in W [m/s]
  Vector omega{};  // in W [rad/s]
  std::optional<Elbow> elbow = {};
  bool finished = false;
};

using Command = std::variant<JointPositions, JointVelocities, CartesianPose, CartesianVelocities>;

/// The command as a sample that answers the robot's state of that time. A quaternion is scaled to
/// norm 1.
/// @throws std::invalid_argument naming what cannot be sent
wire::RobotMotion motion_sample(const Command& command, std::int64_t state_ns);

class Mover : public Process {
 public:
  Mover();
  ~Mover() override;

  /// Once a cycle of the robot, 1,000 times a second: each state that arrives is answered at once.
  /// In lockstep it must depend on nothing but what it is given. What it throws ends the process,
  /// as FAILED on service/status.
  /// @param time of the state, on the session's clock [s]
  /// @return what the arm shall do until the next cycle; none: nothing is sent, which the robot
  /// extrapolates, and after 20 of them it brakes
  virtual std::optional<Command> move(double time, const Effector& now) = 0;

 private:
  class Moving;
  std::unique_ptr<Part> take_part(const Place& place) final;
};

}  // namespace c3rt::client
