#include "controller/model/arm.hpp"

#include <cstdlib>
#include <filesystem>

#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>
#include <pinocchio/parsers/urdf.hpp>
#include <urdf_parser/urdf_parser.h>

namespace c3rt::model {

namespace {

constexpr int kJoints = 7;

pinocchio::Model load(const ArmDescription& description) {
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

  pinocchio::Model model;
  pinocchio::urdf::buildModel(tree, model);
  if (model.nq != kJoints || model.nv != kJoints) {
    throw ArmError(path + ": expected 7 joints before " + name + ", got " +
                   std::to_string(model.nv));
  }
  const pinocchio::Frame& flange_frame = model.frames[model.getFrameId(name)];
  const Eigen::Vector3d inertia(tool.inertia_xx, tool.inertia_xx, tool.inertia_zz);
  const pinocchio::Inertia end_effector(tool.mass, Eigen::Vector3d(0, 0, tool.center_of_mass_z),
                                        inertia.asDiagonal().toDenseMatrix());
  model.appendBodyToJoint(flange_frame.parentJoint, end_effector, flange_frame.placement);
  const pinocchio::SE3 X_flange_E(Eigen::Matrix3d::Identity(),
                                  Eigen::Vector3d(0, 0, tool.sphere_center_z));
  model.addFrame(pinocchio::Frame("E", flange_frame.parentJoint,
                                  flange_frame.placement * X_flange_E, pinocchio::OP_FRAME));
  return model;
}

}  // namespace

struct Arm::Workspace {
  explicit Workspace(pinocchio::Model loaded)
      : model(std::move(loaded)),
        data(model),
        E(model.getFrameId("E")),
        q(kJoints),
        dq(kJoints),
        J(6, kJoints) {
    J.setZero();
  }
  pinocchio::Model model;
  pinocchio::Data data;
  pinocchio::FrameIndex E;
  Eigen::VectorXd q, dq;
  pinocchio::Data::Matrix6x J;
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
