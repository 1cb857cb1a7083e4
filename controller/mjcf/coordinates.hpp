#pragma once
// The coordinates of a mechanism (scene/mechanism.hpp) and MuJoCo's: the only place that knows how
// they differ, which is at free joints. There MuJoCo has the body's origin where we have the centre
// of mass, a quaternion where we have a rotation vector, and ω in the body's axes where we have
// W's.
#include <vector>

#include <Eigen/Core>
#include <mujoco/mujoco.h>

#include "controller/mjcf/loaded.hpp"

namespace c3rt::mjcf {

/// q and v have the order of MuJoCo's qvel.
class Coordinates {
 public:
  Coordinates() = default;
  /// Of this model and of any copy of it. @param loaded at home: rotations count from there
  explicit Coordinates(const Loaded& loaded);

  /// RT: no heap, no throw.
  void to_mujoco(const Eigen::Ref<const Eigen::VectorXd>& q,
                 const Eigen::Ref<const Eigen::VectorXd>& v, mjData* data) const noexcept;
  void from_mujoco(const mjData* data, Eigen::Ref<Eigen::VectorXd> q,
                   Eigen::Ref<Eigen::VectorXd> v) const noexcept;
  /// v̇ of MuJoCo's qacc. @param v where data is
  void acceleration(const mjData* data, const Eigen::Ref<const Eigen::VectorXd>& v,
                    Eigen::Ref<Eigen::VectorXd> a) const noexcept;
  /// T: MuJoCo's qvel = T v. @param T (n_v × n_v) is the identity where it is not overwritten
  void velocity_map(const mjData* data, Eigen::MatrixXd& T) const noexcept;

 private:
  struct FreeJoint {
    int qpos, dof;
    Eigen::Vector3d p_BC;    // centre of mass from the body's origin, in its axes [m]
    Eigen::Matrix3d R_home;  // the body's axes at home
  };
  struct Joint {
    int qpos, dof;
  };

  std::vector<FreeJoint> free_;
  std::vector<Joint> others_;
};

}  // namespace c3rt::mjcf
