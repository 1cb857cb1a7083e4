#pragma once
// The full model M_f of the arm: kinematics and dynamics of seven joints with the spherical end
// effector. Pinocchio is named in arm.cpp only.
#include <memory>
#include <stdexcept>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace c3rt::model {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Matrix67d = Eigen::Matrix<double, 6, 7>;

/// No arm can be built; the text names the file and what to do.
class ArmError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The rod with the ball at its end, bolted to the flange. Frame of the numbers: the flange.
struct EndEffector {
  double mass;              // [kg]
  double center_of_mass_z;  // [m]
  double inertia_xx;        // about the centre of mass; also yy [kg m^2]
  double inertia_zz;        // [kg m^2]
  double sphere_center_z;   // E [m]
};

/// What an arm is built from: config/robots has the numbers.
struct ArmDescription {
  std::string urdf_path;
  std::string flange;  // link that carries the end effector, behind seven joints
  EndEffector end_effector;
};

/// Everything that the law needs at one (q, dq). W = the robot's base frame; E = the sphere's
/// centre with the orientation of the flange.
struct ArmState {
  Eigen::Isometry3d X_WE;  // pose of E
  Matrix67d J_WE;          // geometric Jacobian of E, [linear; angular] in W
  Vector6d V_WE;           // J dq [m/s; rad/s]
  Matrix7d M;              // mass matrix, symmetric [kg m^2]
  Vector7d coriolis;       // C(q, dq) dq [N m]
  Vector7d gravity;        // g(q) [N m]: M ddq + C dq + g = tau
};

/// The arm's rigid-body dynamics. Movable, not copyable (it owns work space).
class Arm {
 public:
  /// Reads seven joints from a URDF; the hand below the flange is left out, the end effector put
  /// on.
  /// @throws ArmError if the file is missing, is no URDF, or has no such flange behind seven
  /// joints.
  explicit Arm(const ArmDescription& description);
  Arm(Arm&&) noexcept;
  Arm& operator=(Arm&&) noexcept;
  ~Arm();

  /// RT: no heap, no lock, no throw.
  void update(const Vector7d& q, const Vector7d& dq, ArmState& out) noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

/// The URDF of a robot's description: the environment's C3RT_PANDA_URDF, else `named` where it is
/// absolute, else share/c3rt/models beside an installed program, else where ./c3rt setup put it.
std::string urdf_path(const std::string& named);

}  // namespace c3rt::model
