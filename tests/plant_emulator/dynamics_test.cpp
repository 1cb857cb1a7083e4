// The arm in MuJoCo against Pinocchio's reading of the URDF, which the law has (model::Arm).
#include <random>
#include <string>

#include <catch2/catch.hpp>
#include <urdf_parser/urdf_parser.h>

#include "plant_emulator/plant.hpp"
#include "plant_emulator/scene.hpp"
#include "tests/plant_emulator/parameters.hpp"
#include "tests/support/panda.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

constexpr double kAgreement = 1e-6;

TEST_CASE("the arm's mass matrix, bias forces, tool pose and Jacobian are Pinocchio's") {
  model::Arm reference(test::panda_arm());
  model::ArmState expected;

  const plant::Model model = build_model(test_scene());
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

    reference.update(q, dq, expected);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WE(data->site_xmat +
                                                                              9 * site);
    const Eigen::Map<const Eigen::Vector3d> p_WE(data->site_xpos + 3 * site);

    const auto grows = [](double& worst, const auto& difference) {
      worst = std::max(worst, difference.cwiseAbs().maxCoeff());
    };
    grows(worst_mass, (mass.topLeftCorner<kJoints, kJoints>() - expected.M).eval());
    grows(worst_bias,
          (Eigen::Map<const Vector7d>(data->qfrc_bias) - expected.coriolis - expected.gravity)
              .eval());
    grows(worst_pose, (p_WE - expected.X_WE.translation()).eval());
    grows(worst_pose, (R_WE - expected.X_WE.linear()).eval());
    grows(worst_jacobian, (J - expected.J_WE).eval());
  }
  CAPTURE(worst_mass, worst_bias, worst_pose, worst_jacobian);
  CHECK(worst_mass < kAgreement);
  CHECK(worst_bias < kAgreement);
  CHECK(worst_pose < kAgreement);
  CHECK(worst_jacobian < kAgreement);
}

TEST_CASE("the joints' limits are the URDF's") {
  const urdf::ModelInterfaceSharedPtr urdf = urdf::parseURDFFile(test::panda_arm().urdf_path);
  REQUIRE(urdf);
  const JointLimits limits = test_parameters().limits;
  const plant::Model model = build_model(test_scene());
  for (int i = 0; i < kJoints; ++i) {
    const urdf::JointConstSharedPtr joint = urdf->getJoint("panda_joint" + std::to_string(i + 1));
    REQUIRE(joint);
    CHECK(limits.q_min[i] == joint->limits->lower);
    CHECK(limits.q_max[i] == joint->limits->upper);
    CHECK(limits.dq_max[i] == joint->limits->velocity);
    CHECK(limits.tau_max[i] == joint->limits->effort);
    CHECK(model->dof_damping[i] == joint->dynamics->damping);
  }
}

}  // namespace
