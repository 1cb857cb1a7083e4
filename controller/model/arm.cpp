#include "controller/model/arm.hpp"

#include <cstdlib>
#include <filesystem>

#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>
#include <urdf_parser/urdf_parser.h>

namespace c3rt::model {

namespace {

constexpr int kJoints = 7;

/// The kinds of joints that an arm may have. Pinocchio's algorithms are compiled for each kind:
/// its own list has 26 of them, and with its own reader of URDF that list must be taken.
template <typename Scalar, int Options>
struct JointsOfArms {
  using Z = pinocchio::JointModelRevoluteTpl<Scalar, Options, 2>;
  using Revolute = pinocchio::JointModelRevoluteUnalignedTpl<Scalar, Options>;
  using Prismatic = pinocchio::JointModelPrismaticUnalignedTpl<Scalar, Options>;
  using JointModelVariant = boost::variant<Z, Revolute, Prismatic>;
  using JointDataVariant =
      boost::variant<pinocchio::JointDataRevoluteTpl<Scalar, Options, 2>,
                     pinocchio::JointDataRevoluteUnalignedTpl<Scalar, Options>,
                     pinocchio::JointDataPrismaticUnalignedTpl<Scalar, Options>>;
};
using Joints = JointsOfArms<double, 0>;
using Model = pinocchio::ModelTpl<double, 0, JointsOfArms>;
using Data = pinocchio::DataTpl<double, 0, JointsOfArms>;

pinocchio::SE3 pose(const urdf::Pose& read) {
  const auto& [p, q] = read;
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z).matrix(), Eigen::Vector3d(p.x, p.y, p.z)};
}

pinocchio::Inertia inertia(const urdf::Inertial& read) {
  const pinocchio::SE3 X = pose(read.origin);
  Eigen::Matrix3d I;
  I << read.ixx, read.ixy, read.ixz, read.ixy, read.iyy, read.iyz, read.ixz, read.iyz, read.izz;
  return {read.mass, X.translation(), X.rotation() * I * X.rotation().transpose()};
}

/// The kind of a joint that moves.
Model::JointModel kind(const urdf::Joint& joint, const ArmDescription& description) {
  const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
  if (joint.type == urdf::Joint::PRISMATIC) return Joints::Prismatic(axis.normalized());
  if (joint.type != urdf::Joint::REVOLUTE) {
    throw ArmError(description.urdf_path + ": joint " + joint.name + " before " +
                   description.flange + ": expected one that turns between limits or slides");
  }
  if (axis.isApprox(Eigen::Vector3d::UnitZ())) return Joints::Z();
  return Joints::Revolute(axis.normalized());
}

/// Puts what `link` carries on the model: a joint where there is one that moves, and a frame with
/// the link's name. To the last bit as Pinocchio's own reader, for the Panda.
void add_children(const urdf::Link& link, pinocchio::FrameIndex of_link,
                  const ArmDescription& description, Model& model) {
  for (const urdf::LinkSharedPtr& child : link.child_links) {
    const urdf::Joint& joint = *child->parent_joint;
    pinocchio::JointIndex carrier = model.frames[of_link].parentJoint;
    pinocchio::SE3 X_carrier_child =
        model.frames[of_link].placement * pose(joint.parent_to_joint_origin_transform);
    if (joint.type != urdf::Joint::FIXED) {
      carrier = model.addJoint(carrier, kind(joint, description), X_carrier_child, joint.name);
      X_carrier_child.setIdentity();
    }
    if (child->inertial)
      model.appendBodyToJoint(carrier, inertia(*child->inertial), X_carrier_child);
    const pinocchio::FrameIndex of_child =
        model.addBodyFrame(child->name, carrier, X_carrier_child, static_cast<int>(of_link));
    add_children(*child, of_child, description, model);
  }
}

Model load(const ArmDescription& description) {
  const auto& [path, name, tool] = description;
  if (!std::filesystem::is_regular_file(path)) {
    throw ArmError("robot model not found: " + path +
                   " (run ./c3rt setup, or set C3RT_PANDA_URDF to the Panda's URDF)");
  }
  const urdf::ModelInterfaceSharedPtr tree = urdf::parseURDFFile(path);
  if (!tree) throw ArmError(path + ": not a URDF");
  urdf::LinkSharedPtr flange;
  tree->getLink(name, flange);
  if (!flange) throw ArmError(path + ": no link " + name);
  // the gripper is not on the robot: neither its joints nor its inertia may stay
  flange->child_links.clear();
  flange->child_joints.clear();

  Model model;
  const urdf::Link& root = *tree->getRoot();
  add_children(root, model.addBodyFrame(root.name, 0, pinocchio::SE3::Identity(), 0), description,
               model);
  if (model.nv != kJoints) {
    throw ArmError(path + ": expected 7 joints before " + name + ", got " +
                   std::to_string(model.nv));
  }
  const pinocchio::Frame flange_frame = model.frames[model.getFrameId(name)];
  const Eigen::Vector3d inertia_of_tool(tool.inertia_xx, tool.inertia_xx, tool.inertia_zz);
  const pinocchio::Inertia end_effector(tool.mass, Eigen::Vector3d(0, 0, tool.center_of_mass_z),
                                        inertia_of_tool.asDiagonal().toDenseMatrix());
  model.appendBodyToJoint(flange_frame.parentJoint, end_effector, flange_frame.placement);
  const pinocchio::SE3 X_flange_E(Eigen::Matrix3d::Identity(),
                                  Eigen::Vector3d(0, 0, tool.sphere_center_z));
  model.addFrame(pinocchio::Frame("E", flange_frame.parentJoint, 0,
                                  flange_frame.placement * X_flange_E, pinocchio::OP_FRAME));
  return model;
}

}  // namespace

struct Arm::Workspace {
  explicit Workspace(Model loaded)
      : model(std::move(loaded)),
        data(model),
        E(model.getFrameId("E")),
        q(kJoints),
        dq(kJoints),
        J(6, kJoints) {
    J.setZero();
  }
  Model model;
  Data data;
  pinocchio::FrameIndex E;
  Eigen::VectorXd q, dq;
  Data::Matrix6x J;
};

Arm::Arm(const ArmDescription& description)
    : workspace_(std::make_unique<Workspace>(load(description))) {}
Arm::Arm(Arm&&) noexcept = default;
Arm& Arm::operator=(Arm&&) noexcept = default;
Arm::~Arm() = default;

void Arm::update(const Vector7d& q, const Vector7d& dq, ArmState& out) noexcept {
  auto& [model, data, E, q_, dq_, J] = *workspace_;
  q_ = q;
  dq_ = dq;

  pinocchio::computeJointJacobians(model, data, q_);
  const pinocchio::SE3& X_WE = pinocchio::updateFramePlacement(model, data, E);
  out.X_WE.linear() = X_WE.rotation();
  out.X_WE.translation() = X_WE.translation();
  out.X_WE.makeAffine();
  pinocchio::getFrameJacobian(model, data, E, pinocchio::LOCAL_WORLD_ALIGNED, J);
  out.J_WE = J;
  out.V_WE.noalias() = out.J_WE * dq;

  pinocchio::crba(model, data, q_);  // fills the upper triangle
  out.M = data.M;
  out.M.triangularView<Eigen::StrictlyLower>() = data.M.transpose();

  out.gravity = pinocchio::computeGeneralizedGravity(model, data, q_);
  out.coriolis = pinocchio::nonLinearEffects(model, data, q_, dq_) - out.gravity;
}

std::string urdf_path(const std::string& named) {
  const char* chosen = std::getenv("C3RT_PANDA_URDF");
  if (chosen != nullptr && *chosen != '\0') return chosen;
  // beside the program where that is installed, and only then where the build had it
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed =
      (program.parent_path() / "../share/c3rt/models" / named).lexically_normal();
  if (!error && fs::exists(installed, error)) return installed.string();
  return (fs::path(C3RT_ROBOT_MODELS) / named).string();
}

}  // namespace c3rt::model
