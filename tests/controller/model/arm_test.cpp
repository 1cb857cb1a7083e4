#include "controller/model/arm.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "tests/support/allocation_counter.hpp"
#include "tests/support/panda.hpp"

using namespace c3rt;
using namespace c3rt::model;

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Arm panda() { return Arm(test::panda_arm()); }

ArmDescription with_urdf(const std::string& path) {
  ArmDescription description = test::panda_arm();
  description.urdf_path = path;
  return description;
}

/// The arm once more from the URDF's numbers, by the definitions: frames multiplied out, M from the
/// links' kinetic energies, gravity from their heights. Shares no code with Pinocchio.
struct Link {
  double roll;                  // of the joint's origin in the link before [rad]
  Vector3d p;                   // of the same [m]
  double mass;                  // [kg]
  Vector3d com;                 // [m]
  Vector3d xx_xy_xz, yy_yz_zz;  // inertia about the centre of mass [kg m^2]
};

constexpr double kQuarter = M_PI / 2;

// clang-format off
const Link kLinks[7] = {
    {0, {0, 0, 0.333}, 4.970684, {0.003875, 0.002081, -0.04762},
     {0.70337, -0.000139, 0.006772}, {0.70661, 0.019169, 0.009117}},
    {-kQuarter, {0, 0, 0}, 0.646926, {-0.003141, -0.02872, 0.003495},
     {0.007962, -0.003925, 0.010254}, {0.02811, 0.000704, 0.025995}},
    {kQuarter, {0, -0.316, 0}, 3.228604, {0.027518, 0.039252, -0.066502},
     {0.037242, -0.004761, -0.011396}, {0.036155, -0.012805, 0.01083}},
    {kQuarter, {0.0825, 0, 0}, 3.587895, {-0.05317, 0.104419, 0.027454},
     {0.025853, 0.007796, -0.001332}, {0.019552, 0.008641, 0.028323}},
    {-kQuarter, {-0.0825, 0.384, 0}, 1.225946, {-0.011953, 0.041065, -0.038437},
     {0.035549, -0.002117, -0.004037}, {0.029474, 0.000229, 0.008627}},
    {kQuarter, {0, 0, 0}, 1.666555, {0.060149, -0.014117, -0.010517},
     {0.001964, 0.000109, -0.001158}, {0.004354, 0.000341, 0.005433}},
    {kQuarter, {0.088, 0, 0}, 0.735522, {0.010517, -0.004252, 0.061597},
     {0.012516, -0.000428, -0.001196}, {0.010027, -0.000741, 0.004815}},
};
// clang-format on

struct Definition {
  Matrix7d M = Matrix7d::Zero();
  double potential = 0;
  Eigen::Isometry3d X_WE;
};

Definition by_definition(const Vector7d& q) {
  Definition result;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  Vector3d axis[7], origin[7];
  const auto add_body = [&](int joints, double mass, const Vector3d& com, const Matrix3d& inertia) {
    const Vector3d p = X * com;
    const Matrix3d I = X.linear() * inertia * X.linear().transpose();
    Eigen::Matrix<double, 3, 7> J_v = Eigen::Matrix<double, 3, 7>::Zero();
    Eigen::Matrix<double, 3, 7> J_w = Eigen::Matrix<double, 3, 7>::Zero();
    for (int i = 0; i < joints; ++i) {
      J_v.col(i) = axis[i].cross(p - origin[i]);
      J_w.col(i) = axis[i];
    }
    result.M += mass * J_v.transpose() * J_v + J_w.transpose() * I * J_w;
    result.potential += mass * 9.81 * p.z();
  };
  for (int i = 0; i < 7; ++i) {
    const Link& link = kLinks[i];
    X = X * Eigen::Translation3d(link.p) * Eigen::AngleAxisd(link.roll, Vector3d::UnitX());
    axis[i] = X.linear().col(2);
    origin[i] = X.translation();
    X = X * Eigen::AngleAxisd(q[i], Vector3d::UnitZ());
    Matrix3d I;
    const Vector3d &a = link.xx_xy_xz, &b = link.yy_yz_zz;
    I << a[0], a[1], a[2], a[1], b[0], b[1], a[2], b[1], b[2];
    add_body(i + 1, link.mass, link.com, I);
  }
  X = X * Eigen::Translation3d(0, 0, 0.107);  // the flange
  add_body(7, 0.269, Vector3d(0, 0, 0.056), Vector3d(1.5176e-4, 1.5176e-4, 4.9476e-5).asDiagonal());
  result.X_WE = X * Eigen::Translation3d(0, 0, 0.1265);
  return result;
}

const Vector7d kMin =
    (Vector7d() << -2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973).finished();
const Vector7d kMax =
    (Vector7d() << 2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973).finished();

class RandomStates {
 public:
  Vector7d q() {
    return kMin +
           (kMax - kMin).cwiseProduct(Vector7d::NullaryExpr([&] { return unit_(generator_); }));
  }
  Vector7d dq() {
    return Vector7d::NullaryExpr([&] { return 4 * unit_(generator_) - 2; });
  }

 private:
  std::mt19937 generator_{7};
  std::uniform_real_distribution<double> unit_{0, 1};
};

constexpr double kStep = 1e-6;  // of central differences: errors of about 1e-9

TEST_CASE("arm: its poses, mass matrix and gravity are those of the URDF's definitions") {
  Arm arm = panda();
  RandomStates random;
  ArmState state;
  for (int n = 0; n < 50; ++n) {
    const Vector7d q = random.q();
    arm.update(q, random.dq(), state);
    const Definition expected = by_definition(q);
    CHECK((state.X_WE.matrix() - expected.X_WE.matrix()).norm() < 1e-12);
    CHECK((state.M - expected.M).norm() < 1e-11);
    for (int i = 0; i < 7; ++i) {
      Vector7d plus = q, minus = q;
      plus[i] += kStep;
      minus[i] -= kStep;
      const double slope =
          (by_definition(plus).potential - by_definition(minus).potential) / (2 * kStep);
      CHECK(state.gravity[i] == Approx(slope).margin(1e-7));
    }
  }
}

TEST_CASE("arm: Coriolis forces follow from the mass matrix's change (Lagrange)") {
  // C dq = dM/dt dq - 1/2 d(dq^T M dq)/dq
  Arm arm = panda();
  RandomStates random;
  ArmState state;
  for (int n = 0; n < 30; ++n) {
    const Vector7d q = random.q(), dq = random.dq();
    arm.update(q, dq, state);
    const Matrix7d M_dot =
        (by_definition(q + kStep * dq).M - by_definition(q - kStep * dq).M) / (2 * kStep);
    Vector7d expected = M_dot * dq;
    for (int i = 0; i < 7; ++i) {
      Vector7d plus = q, minus = q;
      plus[i] += kStep;
      minus[i] -= kStep;
      expected[i] -=
          0.5 * dq.dot((by_definition(plus).M - by_definition(minus).M) * dq) / (2 * kStep);
    }
    CHECK((state.coriolis - expected).norm() < 1e-6);
  }
}

TEST_CASE("arm: the Jacobian is the derivative of the pose, in world axes, linear first") {
  Arm arm = panda();
  RandomStates random;
  ArmState state, plus, minus;
  for (int n = 0; n < 30; ++n) {
    const Vector7d q = random.q(), dq = random.dq();
    arm.update(q, dq, state);
    for (int i = 0; i < 7; ++i) {
      const Vector7d dqi = kStep * Vector7d::Unit(i);
      arm.update(q + dqi, dq, plus);
      arm.update(q - dqi, dq, minus);
      Vector6d column;
      column.head<3>() = (plus.X_WE.translation() - minus.X_WE.translation()) / (2 * kStep);
      const Eigen::AngleAxisd turn(Matrix3d(plus.X_WE.linear() * minus.X_WE.linear().transpose()));
      column.tail<3>() = turn.axis() * turn.angle() / (2 * kStep);
      CHECK((state.J_WE.col(i) - column).norm() < 1e-7);
    }
    CHECK((state.V_WE - state.J_WE * dq).norm() < 1e-12);
  }
}

TEST_CASE("arm: the mass matrix is symmetric and positive definite") {
  Arm arm = panda();
  RandomStates random;
  ArmState state;
  for (int n = 0; n < 50; ++n) {
    arm.update(random.q(), random.dq(), state);
    CHECK(state.M == state.M.transpose());
    CHECK(Eigen::SelfAdjointEigenSolver<Matrix7d>(state.M).eigenvalues().minCoeff() > 1e-3);
  }
}

TEST_CASE(
    "arm: at the paper's start and null-space postures the ball of the tool hangs over (0.55, 0)") {
  // heights derived for the paper's authors' model; the Panda's geometry is the same here
  Arm arm = panda();
  ArmState state;
  const Matrix3d down = Vector3d(1, -1, -1).asDiagonal();
  arm.update((Vector7d() << 0, 0.275, 0, -2.222, 0, 2.497, 0).finished(), Vector7d::Zero(), state);
  CHECK((state.X_WE.translation() - Vector3d(0.5499, 0, 0.1238)).norm() < 1e-4);
  CHECK((state.X_WE.linear() - down).norm() < 1e-3);
  arm.update((Vector7d() << 0, 0.361, 0, -2.223, 0, 2.584, 0).finished(), Vector7d::Zero(), state);
  CHECK((state.X_WE.translation() - Vector3d(0.5500, 0, 0.0838)).norm() < 1e-4);
  CHECK((state.X_WE.linear() - down).norm() < 1e-3);
}

TEST_CASE("arm: a missing or unusable model is refused by its path, with what to do") {
  CHECK_THROWS_AS(Arm(with_urdf("/nowhere/panda.urdf")), ArmError);
  CHECK_THROWS_WITH(Arm(with_urdf("/nowhere/panda.urdf")), Catch::Contains("/nowhere/panda.urdf") &&
                                                               Catch::Contains("./c3rt setup") &&
                                                               Catch::Contains("C3RT_PANDA_URDF"));
  const std::string not_a_urdf = std::string(C3RT_SOURCE_DIRECTORY) + "/CMakeLists.txt";
  CHECK_THROWS_WITH(Arm(with_urdf(not_a_urdf)), Catch::Contains("CMakeLists.txt: not a URDF"));
}

struct Joint {
  const char* type;
  Vector3d axis;
};

/// Seven joints along x, 0.1 m apart, in a file.
ArmDescription in_a_row(const std::vector<Joint>& joints) {
  ArmDescription arm = with_urdf(std::string(C3RT_BINARY_DIRECTORY) + "/in_a_row.urdf");
  arm.flange = "link7";
  std::ofstream file(arm.urdf_path);
  file << "<robot name=\"row\"><link name=\"link0\"/>";
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Vector3d& axis = joints[i].axis;
    file << "<link name=\"link" << i + 1 << "\"/><joint name=\"joint" << i + 1 << "\" type=\""
         << joints[i].type << "\"><origin xyz=\"0.1 0 0\"/><parent link=\"link" << i
         << "\"/><child link=\"link" << i + 1 << "\"/><axis xyz=\"" << axis.x() << ' ' << axis.y()
         << ' ' << axis.z() << "\"/>"
         << "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>";
  }
  file << "</robot>";
  return arm;
}

TEST_CASE("arm: joints turn about any axis or slide along it") {
  const std::vector<Joint> joints{{"revolute", {1, 0, 0}},  {"revolute", {0, 1, 0}},
                                  {"revolute", {0, 0, 1}},  {"revolute", {0, 0, -1}},
                                  {"revolute", {2, -1, 2}}, {"prismatic", {0, 1, 0}},
                                  {"prismatic", {0, 3, 4}}};
  const ArmDescription description = in_a_row(joints);
  Arm arm(description);
  ArmState state;
  arm.update(Vector7d::Zero(), Vector7d::Zero(), state);
  const Vector3d p_WE(0.7, 0, description.end_effector.sphere_center_z);
  CHECK((state.X_WE.translation() - p_WE).norm() < 1e-12);
  for (int i = 0; i < 7; ++i) {
    CAPTURE(i);
    const Vector3d axis = joints[i].axis.normalized();
    Vector6d column = Vector6d::Zero();
    if (joints[i].type == std::string("prismatic")) {
      column.head<3>() = axis;
    } else {
      column << axis.cross(p_WE - Vector3d(0.1 * (i + 1), 0, 0)), axis;
    }
    CHECK((state.J_WE.col(i) - column).norm() < 1e-12);
  }
}

TEST_CASE("arm: a joint of another kind is refused by its name, as is another number of joints") {
  std::vector<Joint> joints(7, Joint{"revolute", {0, 0, 1}});
  joints[3].type = "continuous";
  CHECK_THROWS_WITH(Arm(in_a_row(joints)),
                    Catch::Contains("in_a_row.urdf: joint joint4 before link7: expected one"));
  joints[3].type = "fixed";
  CHECK_THROWS_WITH(Arm(in_a_row(joints)),
                    Catch::Contains("expected 7 joints before link7, got 6"));
}

TEST_CASE("arm: a flange that the model does not have is refused by its name") {
  ArmDescription description = test::panda_arm();
  description.flange = "panda_link9";
  CHECK_THROWS_WITH(Arm(description), Catch::Contains("no link panda_link9"));
}

TEST_CASE("arm: the environment chooses another model file") {
  const char* before = std::getenv("C3RT_PANDA_URDF");
  const std::string saved = before == nullptr ? "" : before;
  setenv("C3RT_PANDA_URDF", "/elsewhere/panda.urdf", 1);
  CHECK(test::panda_arm().urdf_path == "/elsewhere/panda.urdf");
  unsetenv("C3RT_PANDA_URDF");
  CHECK(urdf_path("/my/own.urdf") == "/my/own.urdf");
  CHECK(test::panda_arm().urdf_path ==
        std::string(C3RT_THIRD_PARTY) + "/share/panda_description/urdf/panda.urdf");
  if (!saved.empty()) setenv("C3RT_PANDA_URDF", saved.c_str(), 1);
}

TEST_CASE("arm: update does not allocate") {
  Arm arm = panda();
  RandomStates random;
  ArmState state;
  const Vector7d q = random.q(), dq = random.dq();
  std::int64_t heap_calls = 0;
  {
    const support::AllocationCounter heap;
    for (int n = 0; n < 100; ++n) arm.update(q, dq, state);
    heap_calls = heap.count();
  }
  CHECK(heap_calls == 0);
}

}  // namespace
