#pragma once
// Bodies on joints that motors move, with free bodies among them: what they are made of, and how
// they move while nothing touches.
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "controller/scene/distance.hpp"
#include "controller/scene/object.hpp"

namespace c3rt::scene {

/// One entry of q, and of v.
struct Coordinate {
  enum class Kind {
    kSlide,     // along an axis [m]
    kHinge,     // about an axis [rad]
    kPosition,  // of a free body's centre of mass, in W: three in a row [m]
    kRotation,  // of a free body, three in a row: q has the rotation vector in W from where the
                // body is at home [rad], v its angular velocity in W [rad/s]
  };
  Kind kind;
  std::string name;  // of the joint; of a free body with the axis: "disc_x", "disc_turn_z"
  std::string rate;  // the same of v
  int body = 0;      // the rigid body that it moves
};

/// What moves a slide or a hinge by force or torque.
struct Motor {
  std::string name;
  bool turns;       // its joint is a hinge
  double min, max;  // of its input, ±infinity where the file sets no range
};

/// A geom of a body, or of the world.
struct Surface {
  std::string name;
  std::string owner;  // the file's body that it is of, which may be fixed to another one
  int body;           // the rigid body that it is part of; 0: the world
  Part part;          // in the frame of that body
  bool is_plane;      // not a shape but all that is below z of the part's axes
  double friction;    // μ
};

/// What is fixed to each other: parts about the common centre of mass, the axes those of the
/// outermost of the file's bodies. The first is the world, in W, without a mass.
struct RigidBody {
  Object object;  // its parts are those of its surfaces that are no planes, in their order
  bool driven;    // a motor moves it, or what it hangs on
  int parent;     // what it hangs on; of the world and of what is free: 0
};

/// M(q) v̇ + bias(q, v) = B u, linearised: v̇ = f + J_q δq + J_v δv + J_u u.
struct SmoothMotion {
  Eigen::MatrixXd M_inverse;         // (n_v × n_v)
  Eigen::VectorXd f;                 // without inputs (n_v)
  Eigen::MatrixXd J_q, J_v;          // (n_v × n_v)
  Eigen::MatrixXd J_u;               // (n_v × n_u)
  Eigen::MatrixXd N_q, N_q_inverse;  // q̇ = N_q v
};

/// As many velocities as coordinates; q = 0 of a free body's rotation is its orientation at home.
/// One thread at a time: what is asked for is computed in the same storage.
class Mechanism {
 public:
  virtual ~Mechanism() = default;

  const std::vector<Coordinate>& coordinates() const noexcept { return coordinates_; }
  const std::vector<Motor>& motors() const noexcept { return motors_; }
  const std::vector<RigidBody>& bodies() const noexcept { return bodies_; }
  const std::vector<Surface>& surfaces() const noexcept { return surfaces_; }
  /// Where the file puts it.
  const Eigen::VectorXd& home() const noexcept { return home_; }
  const std::string& file() const noexcept { return file_; }
  int n_v() const noexcept { return static_cast<int>(coordinates_.size()); }
  int n_u() const noexcept { return static_cast<int>(motors_.size()); }

  /// No heap where `motion` had these sizes. Afterwards `place` and `jacobian` are of q.
  virtual void evaluate(const Eigen::Ref<const Eigen::VectorXd>& q,
                        const Eigen::Ref<const Eigen::VectorXd>& v, SmoothMotion& motion) = 0;
  /// Of a rigid body: its centre of mass and axes in W.
  virtual Place place(int body) const noexcept = 0;
  /// J of a body's point: its velocity in W is J v. No heap.
  /// @param p_WP in W [m]  @param J (3 × n_v) is overwritten
  virtual void jacobian(int body, const Eigen::Vector3d& p_WP,
                        Eigen::Ref<Eigen::MatrixXd> J) const noexcept = 0;

 protected:
  std::vector<Coordinate> coordinates_;
  std::vector<Motor> motors_;
  std::vector<RigidBody> bodies_;
  std::vector<Surface> surfaces_;
  Eigen::VectorXd home_;
  std::string file_;
};

/// Where q gets to with the velocities v in a time, rotations on SO(3).
void move(const std::vector<Coordinate>& coordinates, const Eigen::VectorXd& v, double time,
          Eigen::VectorXd& q);

/// The rotation of a rotation vector, and the shorter way round back.
Eigen::Matrix3d rotation(const Eigen::Vector3d& turn) noexcept;
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) noexcept;

/// J_l of SO(3): while the rotation vector θ of exp(θ) changes, the angular velocity in W is
/// ω = J_l(θ) θ̇.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& turn) noexcept;

}  // namespace c3rt::scene
