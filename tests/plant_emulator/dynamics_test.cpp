// The arm in MuJoCo against Pinocchio's reading of the URDF.
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include <catch2/catch.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include "plant_emulator/plant.hpp"
#include "plant_emulator/scene.hpp"
#include "tests/plant_emulator/parameters.hpp"

namespace c3rt::plant {
namespace {

constexpr double kAgreement = 1e-6;

/// The URDF without hand and fingers, with the tool's mass on the flange.
pinocchio::Model reference_arm() {
  std::ifstream file(std::string(C3RT_THIRD_PARTY) + "/share/panda_description/urdf/panda.urdf");
  std::string urdf{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::size_t hand = urdf.find("<joint name=\"panda_hand_joint\"");
  REQUIRE(hand != std::string::npos);
  urdf = urdf.substr(0, hand) + "</robot>";
  pinocchio::Model model;
  pinocchio::urdf::buildModelFromXML(urdf, model);
  REQUIRE(model.nv == kJoints);
  const pinocchio::JointIndex last = model.getJointId("panda_joint7");
  const Eigen::Vector3d inertia(1.5176e-4, 1.5176e-4, 4.9476e-5);
  const pinocchio::SE3 flange(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 0.107));
  model.appendBodyToJoint(
      last,
      pinocchio::Inertia(0.269, Eigen::Vector3d(0, 0, 0.056), inertia.asDiagonal().toDenseMatrix()),
      flange);
  const pinocchio::SE3 sphere(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 0.107 + 0.1265));
  model.addFrame(pinocchio::Frame("sphere", last, 0, sphere, pinocchio::OP_FRAME));
  return model;
}

TEST_CASE("the arm's mass matrix, bias forces, tool pose and Jacobian are Pinocchio's") {
  pinocchio::Model reference = reference_arm();
  pinocchio::Data reference_data(reference);
  const pinocchio::FrameIndex sphere = reference.getFrameId("sphere");

  const Model model = build_model(test_scene());
  const Data data(mj_makeData(model.get()));
  const int site = mj_name2id(model.get(), mjOBJ_SITE, "end_effector");
  const int nv = model->nv;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  const JointLimits limits = test_parameters().limits;
  std::mt19937 random(20221122);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double worst_mass = 0, worst_bias = 0, worst_pose = 0, worst_jacobian = 0;
  for (int trial = 0; trial < 100; ++trial) {
    Vector7d q, dq;
    for (int i = 0; i < kJoints; ++i) {
      q[i] = limits.q_min[i] + unit(random) * (limits.q_max[i] - limits.q_min[i]);
      dq[i] = (2 * unit(random) - 1) * limits.dq_max[i];
    }
    Eigen::Map<Vector7d>(data->qpos) = q;
    Eigen::Map<Vector7d>(data->qvel) = dq;
    mj_forward(model.get(), data.get());
    RowMajor mass(nv, nv), linear(3, nv), angular(3, nv);
    mj_fullM(model.get(), mass.data(), data->qM);
    mj_jacSite(model.get(), data.get(), linear.data(), angular.data(), site);
    Eigen::Matrix<double, 6, kJoints> J;
    J << linear.leftCols<kJoints>(), angular.leftCols<kJoints>();

    const Eigen::VectorXd bias = pinocchio::nonLinearEffects(reference, reference_data, q, dq);
    pinocchio::crba(reference, reference_data, Eigen::VectorXd(q));
    Eigen::MatrixXd reference_mass = reference_data.M;
    reference_mass.triangularView<Eigen::StrictlyLower>() = reference_mass.transpose();
    Eigen::MatrixXd reference_J = Eigen::MatrixXd::Zero(6, kJoints);
    pinocchio::computeFrameJacobian(reference, reference_data, Eigen::VectorXd(q), sphere,
                                    pinocchio::LOCAL_WORLD_ALIGNED, reference_J);
    pinocchio::framesForwardKinematics(reference, reference_data, Eigen::VectorXd(q));
    const pinocchio::SE3& X_WE = reference_data.oMf[sphere];
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WE(data->site_xmat +
                                                                              9 * site);
    const Eigen::Map<const Eigen::Vector3d> p_WE(data->site_xpos + 3 * site);

    worst_mass =
        std::max(worst_mass,
                 (mass.topLeftCorner<kJoints, kJoints>() - reference_mass).cwiseAbs().maxCoeff());
    worst_bias = std::max(
        worst_bias, (Eigen::Map<const Vector7d>(data->qfrc_bias) - bias).cwiseAbs().maxCoeff());
    worst_pose = std::max({worst_pose, (p_WE - X_WE.translation()).cwiseAbs().maxCoeff(),
                           (R_WE - X_WE.rotation()).cwiseAbs().maxCoeff()});
    worst_jacobian = std::max(worst_jacobian, (J - reference_J).cwiseAbs().maxCoeff());
  }
  CAPTURE(worst_mass, worst_bias, worst_pose, worst_jacobian);
  CHECK(worst_mass < kAgreement);
  CHECK(worst_bias < kAgreement);
  CHECK(worst_pose < kAgreement);
  CHECK(worst_jacobian < kAgreement);
}

TEST_CASE("the joints' limits are the URDF's") {
  const pinocchio::Model reference = reference_arm();
  const JointLimits limits = test_parameters().limits;
  CHECK(limits.q_min == Vector7d(reference.lowerPositionLimit));
  CHECK(limits.q_max == Vector7d(reference.upperPositionLimit));
  CHECK(limits.dq_max == Vector7d(reference.velocityLimit));
  CHECK(limits.tau_max == Vector7d(reference.effortLimit));
  const Model model = build_model(test_scene());
  CHECK((Eigen::Map<Vector7d>(model->dof_damping) == Vector7d(reference.damping)));
}

}  // namespace
}  // namespace c3rt::plant
