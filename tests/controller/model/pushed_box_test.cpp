#include "controller/model/pushed_box.hpp"

#include <cmath>
#include <functional>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "controller/lcs/lemke.hpp"
#include "controller/lcs/step.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/model/contact_model.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::model;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using L = PushedBoxLayout;

namespace {

const Vector3d kHalf(0.06, 0.04, 0.03);
const PushedBoxParameters kBox{1.0, 0.0195, 0.5, kHalf, -0.02, 0.5, 0.4};
constexpr double kStep = 1e-6;

/// A box in the air, turned and turning anyhow, and an end effector outside it.
scene::Scene anywhere(unsigned seed) {
  support::Random random(seed);
  scene::Scene scene = make_pushed_box(kBox)->layout().world;
  scene::Body& box = scene.body(0);
  box.p_WB = Vector3d(0.5, 0.0, 0.05) + 0.1 * random.vector(3);
  box.q_WB = Eigen::Quaterniond(Eigen::Vector4d(random.vector(4)).normalized());
  box.v_WB = random.vector(3);
  box.omega_WB = 3.0 * random.vector(3);
  scene.effector.v_WE = random.vector(3);
  do {
    scene.effector.p_WE = box.p_WB + 0.2 * random.vector(3);
  } while (scene::gap(scene.effector, box).distance < 5e-3);
  return scene;
}

Eigen::VectorXd velocities(const scene::Scene& scene) {
  Eigen::VectorXd v(L::n_v);
  v << scene.effector.v_WE, scene.body(0).v_WB, scene.body(0).omega_WB;
  return v;
}

Eigen::VectorXd state(const PlanningModel& model, const scene::Scene& scene) {
  Eigen::VectorXd x(L::n_x);
  model.state(scene, x);
  return x;
}

/// Euler's equation of an even box, by hand.
Vector3d angular_acceleration(const scene::Scene& scene) {
  const Matrix3d R = Eigen::Quaterniond(scene.body(0).q_WB).toRotationMatrix();
  const Vector3d s = 4.0 * kHalf.cwiseAbs2();
  const Matrix3d I =
      R *
      Matrix3d((kBox.box_mass / 12.0 * Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()))
                   .asDiagonal()) *
      R.transpose();
  const Vector3d omega = scene.body(0).omega_WB;
  return -I.inverse() * omega.cross(I * omega);
}

}  // namespace

TEST_CASE("pushed box: the registry has it, and its world is a box on the table") {
  const ModelKind& kind = model_kind("pushed_box");
  ModelValues values;
  for (const ModelKey& key : kind.keys) values.set(key.name, 0.05);
  const scene::Scene world = kind.make(values, 1)->layout().world;
  CHECK(world.body_count == 1);
  CHECK(std::string(world.body(0).name.c_str()) == "box");
  CHECK(world.body(0).shape.kind == scene::ShapeKind::kBox);
  CHECK(world.table_height == 0.05);
}

TEST_CASE("pushed box: the state of another scene is the rotation from here") {
  const auto model = make_pushed_box(kBox);
  const scene::Scene here = anywhere(1);
  CHECK(state(*model, here).segment<3>(L::rotation).isZero());
  Eigen::VectorXd v = Eigen::VectorXd::Zero(L::n_v);
  v.tail<3>() << 0.2, -0.3, 0.5;
  Eigen::VectorXd x(L::n_x);
  model->state_about(moved(here, v, 1.0), here, x);
  CHECK((x.segment<3>(L::rotation) - Vector3d(0.2, -0.3, 0.5)).norm() < 1e-12);
  // the shorter way round
  v.tail<3>() << 0.0, 0.0, 2.0 * M_PI - 0.1;
  model->state_about(moved(here, v, 1.0), here, x);
  CHECK((x.segment<3>(L::rotation) - Vector3d(0.0, 0.0, -0.1)).norm() < 1e-12);
}

TEST_CASE("pushed box: gaps and their rates are those of finite differences") {
  const auto model = make_pushed_box(kBox);
  const std::vector<int> all = all_contacts(model->layout());
  for (unsigned seed = 1; seed <= 200; ++seed) {
    CAPTURE(seed);
    const scene::Scene here = anywhere(seed);
    const ContactSystem system = model->contact_system(here, all);
    for (int i = 0; i < L::n_v; ++i) {
      const Eigen::VectorXd v = Eigen::VectorXd::Unit(L::n_v, i);
      const Eigen::VectorXd after = model->contact_system(moved(here, v, kStep), all).phi;
      const Eigen::VectorXd before = model->contact_system(moved(here, v, -kStep), all).phi;
      const Eigen::VectorXd rate = (after - before) / (2.0 * kStep);
      REQUIRE((rate - system.J_n.col(i)).cwiseAbs().maxCoeff() < 1e-6);
    }
  }
}

TEST_CASE("pushed box: the slip along each edge is that of the two material points") {
  const auto model = make_pushed_box(kBox);
  const std::vector<int> all = all_contacts(model->layout());
  for (unsigned seed = 1; seed <= 50; ++seed) {
    CAPTURE(seed);
    const scene::Scene here = anywhere(seed);
    const Eigen::VectorXd v = velocities(here);
    const scene::Body& box = here.body(0);
    const ContactSystem system = model->contact_system(here, all);
    const scene::Scene next = moved(here, v, kStep);
    for (int contact = 0; contact < L::n_c; ++contact) {
      Vector3d point;  // of the box, in its frame
      if (contact == 0) {
        const scene::Gap gap = scene::gap(here.effector, box);
        point = Eigen::Quaterniond(box.q_WB).conjugate() *
                (here.effector.p_WE - (gap.distance + kBox.end_effector_radius) * gap.normal -
                 box.p_WB);
      } else {
        const int corner = contact - 1;
        point = Vector3d((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, -1)
                    .cwiseProduct(kHalf);
      }
      const auto place = [&](const scene::Scene& scene) {
        return Vector3d(scene.body(0).p_WB + Eigen::Quaterniond(scene.body(0).q_WB) * point);
      };
      const Vector3d of_box = (place(next) - place(here)) / kStep;
      const Vector3d relative = contact == 0 ? Vector3d(here.effector.v_WE - of_box) : of_box;
      const Vector3d normal =
          contact == 0 ? scene::gap(here.effector, box).normal : Vector3d::UnitZ();
      const Eigen::VectorXd slips = system.J_t.middleRows<4>(4 * contact) * v;
      CHECK(slips[1] == Approx(-slips[0]));
      CHECK(slips[3] == Approx(-slips[2]));
      // two perpendicular edges hold the whole of what is not along the normal
      const double along = relative.dot(normal);
      CHECK(std::hypot(slips[0], slips[2]) ==
            Approx(std::sqrt(std::max(0.0, relative.squaredNorm() - along * along))).margin(1e-4));
    }
  }
}

TEST_CASE("pushed box: free motion is Euler's, and its Jacobians are those of finite differences") {
  const auto model = make_pushed_box(kBox);
  for (unsigned seed = 1; seed <= 50; ++seed) {
    CAPTURE(seed);
    const scene::Scene here = anywhere(seed);
    const ContactSystem system = model->contact_system(here, {0});
    const Eigen::VectorXd f = system.J_f_v * velocities(here) + system.d_v;
    CHECK((f.tail<3>() - angular_acceleration(here)).norm() < 1e-9);
    CHECK((f.segment<3>(3) - Vector3d(0.0, 0.0, -9.81)).norm() < 1e-12);
    CHECK(f.head<3>().isZero());
    for (int axis = 0; axis < 3; ++axis) {
      const auto difference = [&](const std::function<scene::Scene(double)>& at) {
        return Vector3d((angular_acceleration(at(kStep)) - angular_acceleration(at(-kStep))) /
                        (2.0 * kStep));
      };
      const Vector3d by_omega = difference([&](double by) {
        scene::Scene other = here;
        other.body(0).omega_WB[axis] += by;
        return other;
      });
      CHECK((system.J_f_v.block<3, 1>(6, 6 + axis) - by_omega).norm() < 1e-6);
      const Vector3d by_rotation = difference(
          [&](double by) { return moved(here, Eigen::VectorXd::Unit(L::n_v, 6 + axis), by); });
      CHECK((system.J_f_q.block<3, 1>(6, 6 + axis) - by_rotation).norm() < 1e-6);
    }
    CHECK(system.J_f_u.topRows<3>().isApprox(Matrix3d::Identity() / kBox.end_effector_mass));
    CHECK(system.J_f_u.bottomRows<6>().isZero());
  }
}

TEST_CASE(
    "pushed box: every block of the LCS is that of the step, to the rank that it is linear in") {
  const auto model = make_pushed_box(kBox);
  const std::vector<int> all = all_contacts(model->layout());
  for (const ContactModel contact_model :
       {ContactModel::kAnitescu, ContactModel::kStewartTrinkle}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      CAPTURE(seed);
      scene::Scene scene = anywhere(seed);
      const BlockErrors moving = block_errors(*model, contact_model, scene, all, 0.05);
      CHECK(moving.B < 1e-7);
      CHECK(moving.H < 1e-7);
      CHECK(moving.F < 1e-7);
      CHECK(moving.c < 1e-9);
      scene.body(0).v_WB.setZero();
      scene.body(0).omega_WB.setZero();
      scene.effector.v_WE.setZero();
      const BlockErrors resting = block_errors(*model, contact_model, scene, all, 0.05);
      CHECK(resting.A < 1e-6);
      CHECK(resting.D < 1e-6);
      CHECK(resting.d < 1e-9);
    }
  }
}

namespace {

scene::Scene on_table(const Vector3d& v_WB) {
  scene::Scene scene = make_pushed_box(kBox)->layout().world;
  scene.body(0).p_WB << 0.5, 0.0, kBox.table_height + kHalf.z();
  scene.body(0).v_WB = v_WB;
  scene.effector.p_WE << 0.3, 0.0, kBox.table_height + 0.03;
  return scene;
}

Eigen::VectorXd stepped(const scene::Scene& scene, ContactModel contact_model, double dt) {
  const auto model = make_pushed_box(kBox);
  const std::vector<int> all = all_contacts(model->layout());
  const lcs::Lcs system = to_lcs(contact_model, model->contact_system(scene, all), dt);
  lcs::Lemke lemke(LambdaLayout(contact_model, L::n_c, L::n_e).size());
  Eigen::VectorXd next(L::n_x), lambda(lemke.size());
  REQUIRE(lcs::step(system, state(*model, scene), Vector3d::Zero(), lemke, next, lambda).ok());
  return next;
}

}  // namespace

TEST_CASE("pushed box: at rest it lies still, with either contact model") {
  for (const ContactModel contact_model :
       {ContactModel::kStewartTrinkle, ContactModel::kAnitescu}) {
    const scene::Scene scene = on_table(Vector3d::Zero());
    const Eigen::VectorXd next = stepped(scene, contact_model, 0.01);
    CHECK((next - state(*make_pushed_box(kBox), scene)).norm() < 1e-9);
  }
}

TEST_CASE("pushed box: sliding it slows down by mu g, whatever way it goes") {
  constexpr double dt = 0.01;
  for (double way = 0.0; way < 2.0 * M_PI; way += 0.37) {
    CAPTURE(way);
    const Vector3d v = 0.3 * Vector3d(std::cos(way), std::sin(way), 0.0);
    const Vector3d after =
        stepped(on_table(v), ContactModel::kStewartTrinkle, dt).segment<3>(L::v_WB);
    const double slowed = (v - after).dot(v.normalized()) / dt;
    // the corners' edges are turned: on average they are nearer to the way than those of one cone
    CHECK(slowed < 1.001 * kBox.friction_table * 9.81);
    CHECK(slowed > 0.8 * kBox.friction_table * 9.81);
    CHECK(std::abs(after.z()) < 1e-9);
  }
}
