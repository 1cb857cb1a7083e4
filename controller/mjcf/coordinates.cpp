#include "controller/mjcf/coordinates.hpp"

#include <Eigen/Geometry>

#include "controller/scene/cross_matrix.hpp"
#include "controller/scene/mechanism.hpp"

namespace c3rt::mjcf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Reference = Eigen::Ref<VectorXd>;
using ConstReference = Eigen::Ref<const VectorXd>;

Matrix3d axes(const mjtNum* quaternion) noexcept {
  return Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3])
      .normalized()
      .toRotationMatrix();
}

}  // namespace

Coordinates::Coordinates(const Loaded& loaded) {
  const mjModel* model = loaded.model();
  for (int joint = 0; joint < model->njnt; ++joint) {
    const int qpos = model->jnt_qposadr[joint], dof = model->jnt_dofadr[joint];
    if (model->jnt_type[joint] != mjJNT_FREE) {
      others_.push_back({qpos, dof});
      continue;
    }
    const int body = model->jnt_bodyid[joint];
    const Rigid rigid = loaded.rigid(body);
    const Vector3d from_origin = rigid.p_WC - vector(loaded.data()->xpos + 3 * body);
    free_.push_back({qpos, dof, rigid.R_WB.transpose() * from_origin, rigid.R_WB});
  }
}

void Coordinates::to_mujoco(const ConstReference& q, const ConstReference& v,
                            mjData* data) const noexcept {
  for (const Joint& joint : others_) {
    data->qpos[joint.qpos] = q[joint.dof];
    data->qvel[joint.dof] = v[joint.dof];
  }
  for (const FreeJoint& joint : free_) {
    const Matrix3d R = scene::rotation(q.segment<3>(joint.dof + 3)) * joint.R_home;
    const Vector3d c = R * joint.p_BC, omega = v.segment<3>(joint.dof + 3);
    const Eigen::Quaterniond turned(R);
    Eigen::Map<Vector3d>(data->qpos + joint.qpos) = q.segment<3>(joint.dof) - c;
    Eigen::Map<Eigen::Vector4d>(data->qpos + joint.qpos + 3) << turned.w(), turned.x(), turned.y(),
        turned.z();
    Eigen::Map<Vector3d>(data->qvel + joint.dof) = v.segment<3>(joint.dof) - omega.cross(c);
    Eigen::Map<Vector3d>(data->qvel + joint.dof + 3) = R.transpose() * omega;
  }
}

void Coordinates::from_mujoco(const mjData* data, Reference q, Reference v) const noexcept {
  for (const Joint& joint : others_) {
    q[joint.dof] = data->qpos[joint.qpos];
    v[joint.dof] = data->qvel[joint.dof];
  }
  for (const FreeJoint& joint : free_) {
    const Matrix3d R = axes(data->qpos + joint.qpos + 3);
    const Vector3d c = R * joint.p_BC, omega = R * vector(data->qvel + joint.dof + 3);
    q.segment<3>(joint.dof) = vector(data->qpos + joint.qpos) + c;
    q.segment<3>(joint.dof + 3) = scene::rotation_vector(R * joint.R_home.transpose());
    v.segment<3>(joint.dof) = vector(data->qvel + joint.dof) + omega.cross(c);
    v.segment<3>(joint.dof + 3) = omega;
  }
}

void Coordinates::acceleration(const mjData* data, const ConstReference& v,
                               Reference a) const noexcept {
  for (const Joint& joint : others_) a[joint.dof] = data->qacc[joint.dof];
  for (const FreeJoint& joint : free_) {
    const Matrix3d R = axes(data->qpos + joint.qpos + 3);
    const Vector3d c = R * joint.p_BC, omega = v.segment<3>(joint.dof + 3);
    const Vector3d alpha = R * vector(data->qacc + joint.dof + 3);
    a.segment<3>(joint.dof) =
        vector(data->qacc + joint.dof) + alpha.cross(c) + omega.cross(omega.cross(c));
    a.segment<3>(joint.dof + 3) = alpha;
  }
}

void Coordinates::velocity_map(const mjData* data, Eigen::MatrixXd& T) const noexcept {
  for (const FreeJoint& joint : free_) {
    const Matrix3d R = axes(data->qpos + joint.qpos + 3);
    T.block<3, 3>(joint.dof, joint.dof + 3) = scene::cross_matrix(R * joint.p_BC);
    T.block<3, 3>(joint.dof + 3, joint.dof + 3) = R.transpose();
  }
}

}  // namespace c3rt::mjcf
