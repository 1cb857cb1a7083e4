#include "controller/model/mechanism_model.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>

#include <catch2/catch.hpp>
#include <mujoco/mujoco.h>

#include "controller/mjcf/mechanism.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/model/cart_pole.hpp"
#include "controller/model/objects_model.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/mjcf_file.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::model;
using Catch::Contains;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

const std::string kPusher = C3RT_SOURCE_DIRECTORY "/examples/pusher/pusher.xml";

/// A sphere on three slides, the shipped T above the floor, turned.
const std::string kSphereAndT = R"(
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -0.02"/>
    <body name="tip" pos="0.3 -0.15 0.03">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
      <joint name="z" type="slide" axis="0 0 1"/>
      <geom type="sphere" size="0.0195" mass="1"/>
    </body>
    <body name="t" pos="0.5 0.1 0.06" quat="0.96 0.01 0.02 0.3">
      <freejoint/>
      <geom name="top" type="box" size="0.08 0.02 0.02" mass="0.32"/>
      <geom name="stem" type="box" size="0.02 0.06 0.02" pos="0 -0.08 0" mass="0.24"/>
    </body>
  </worldbody>
  <actuator><motor joint="x"/><motor joint="y"/><motor joint="z"/></actuator>)";

/// Every shape near a finger of two hinges with a capsule, in the air.
const std::string kShapes = R"(
  <compiler angle="radian"/>
  <asset><mesh name="wedge" vertex="0.05 0 0  -0.05 0.04 0  -0.05 -0.04 0  0 0 0.06"/></asset>
  <worldbody>
    <geom name="wall" type="plane" size="1 1 1" pos="-0.6 0 0" zaxis="1 0 0.2"/>
    <geom name="step" type="box" size="0.05 0.2 0.1" pos="0.2 0 -0.2"/>
    <body name="upper"><joint name="shoulder" axis="0 1 0"/>
      <geom name="arm" type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.5"/>
      <body name="lower" pos="0.3 0 0"><joint name="elbow" axis="0 0.6 0.8" damping="0.1"/>
        <geom name="finger" type="capsule" size="0.015" fromto="0.03 0 0 0.25 0 0" mass="0.3"/>
        <geom name="tip" type="sphere" size="0.02" pos="0.25 0 0" mass="0.05"/>
      </body>
    </body>
    <body name="can" pos="0.1 0.4 0.2" quat="0.9 0.3 0.2 0.1"><freejoint/>
      <geom type="cylinder" size="0.04 0.05" mass="0.3"/></body>
    <body name="stone" pos="0.6 -0.3 0.1" quat="0.7 0.1 0.2 0.5"><freejoint/>
      <geom type="mesh" mesh="wedge" mass="0.2"/></body>
    <body name="jack" pos="0.4 0.3 -0.1"><freejoint/>
      <geom type="box" size="0.05 0.02 0.02" mass="0.2"/>
      <geom type="capsule" size="0.015 0.06" pos="0 0.03 0.02" mass="0.1"/></body>
  </worldbody>
  <actuator><motor name="m1" joint="shoulder"/><motor name="m2" joint="elbow" gear="3"/></actuator>)";

MechanismParameters parameters(const std::string& path, std::vector<Between> contacts) {
  MechanismParameters result;
  result.mechanism = mjcf::read_mechanism(path).mechanism;
  result.contacts = std::move(contacts);
  return result;
}

std::vector<Between> of_shapes() {
  return {{"tip", "can", 0, 0.5}, {"finger", "stone", 0, 0.4}, {"lower", "jack", 1, 0.3},
          {"can", "jack", 1},     {"stone", "wall"},           {"arm", "step"},
          {"jack", "wall", 2}};
}

VectorXd home(const MechanismModel& model) {
  VectorXd x = VectorXd::Zero(2 * model.mechanism().n_v());
  x.head(model.mechanism().n_v()) = model.mechanism().home();
  return x;
}

}  // namespace

TEST_CASE("mechanism: a sphere on slides beside a T is the model of objects, to rounding") {
  const test::MjcfFile file(kSphereAndT);
  const scene::Object t = mjcf::read_object(C3RT_SOURCE_DIRECTORY "/config/objects/t.xml").object;
  const auto objects = make_objects_model({1.0, 0.0195, -0.02, 0.5, 0.4, 0.3, 4, false, {t}});
  support::Random random(1);
  for (const ContactModel contact_model :
       {ContactModel::kAnitescu, ContactModel::kStewartTrinkle}) {
    MechanismParameters p = parameters(file.path(), {{"tip", "t", 1, 0.5}, {"floor", "t", 0, 0.4}});
    p.contact_model = contact_model;
    const MechanismModel model(p);
    REQUIRE(model.n_c() == 5);
    VectorXd x = home(model);
    x.tail(9) = random.vector(9);
    ContactSystem system;
    model.evaluate(x, system);
    scene::Scene scene = objects->layout().world;
    scene.effector.p_WE = x.head<3>() + Vector3d(0.3, -0.15, 0.03);
    scene.effector.v_WE = x.segment<3>(9);
    scene::Body& body = scene.body(0);
    body.p_WB = x.segment<3>(3);
    body.q_WB = Eigen::Quaterniond(0.96, 0.01, 0.02, 0.3).normalized();
    body.v_WB = x.segment<3>(12);
    body.omega_WB = x.segment<3>(15);
    ContactSystem expected = objects->contact_system(scene, all_contacts(objects->layout()));
    // the slides have their own origin, and gravity
    expected.q.head<3>() = x.head<3>();
    expected.d_v[2] = -9.81;
    CHECK((system.q - expected.q).norm() < 1e-12);
    CHECK((system.M_inverse - expected.M_inverse).norm() < 1e-9 * expected.M_inverse.norm());
    CHECK((system.J_f_v - expected.J_f_v).norm() < 1e-8);
    // two ways to have the turning of f with the T: by differences here
    CHECK((system.J_f_q - expected.J_f_q).norm() < 1e-7);
    CHECK((system.J_f_u - expected.J_f_u).norm() < 1e-9);
    CHECK((system.d_v - expected.d_v).norm() < 1e-7);
    CHECK((system.phi - expected.phi).norm() < 1e-12);
    CHECK((system.distance - expected.distance).norm() < 1e-12);
    CHECK((system.mu - expected.mu).norm() == 0.0);
    CHECK((system.J_n - expected.J_n).norm() < 1e-9);
    CHECK((system.J_t - expected.J_t).norm() < 1e-9);
    const lcs::Lcs lcs = model.planning_system(x, 0.05),
                   other = to_lcs(contact_model, expected, 0.05);
    for (const auto block :
         {&lcs::Lcs::A, &lcs::Lcs::B, &lcs::Lcs::D, &lcs::Lcs::E, &lcs::Lcs::F, &lcs::Lcs::H}) {
      CHECK((lcs.*block - other.*block).norm() < 1e-7 * (1.0 + (other.*block).norm()));
    }
    CHECK((lcs.c - other.c).norm() < 1e-6);
    CHECK((lcs.d - other.d).norm() < 1e-8);
  }
}

TEST_CASE("mechanism: the cart-pole of section VI-C as MJCF is the one in closed form") {
  const test::MjcfFile file(R"(
    <worldbody>
      <geom name="right" type="plane" size="1 1 1" pos="0.36 0 0" zaxis="-1 0 0"/>
      <geom name="left" type="plane" size="1 1 1" pos="-0.36 0 0" zaxis="1 0 0"/>
      <body name="cart"><joint name="rail" type="slide" axis="1 0 0"/>
        <geom type="sphere" size="0.001" mass="0.978" contype="0" conaffinity="0"/>
        <body name="pole"><joint name="pin" axis="0 -1 0"/>
          <geom type="sphere" size="1e-5" pos="0 0 0.4267" mass="0.411" contype="0" conaffinity="0"/>
          <geom name="tip" type="sphere" size="0.01" pos="0 0 0.6" mass="0"/>
        </body>
      </body>
    </worldbody>
    <actuator><motor name="force" joint="rail"/></actuator>)");
  MechanismParameters p = parameters(file.path(), {{"tip", "right"}, {"tip", "left"}});
  p.directions = 0;
  const MechanismModel model(p);
  ContactSystem system;
  model.evaluate(VectorXd::Zero(4), system);
  const ContactSystem expected = cart_pole_system(CartPoleParameters::simulated());
  CHECK((system.M_inverse - expected.M_inverse).norm() < 1e-9 * expected.M_inverse.norm());
  CHECK((system.J_f_q - expected.J_f_q).norm() < 1e-7);
  CHECK((system.J_f_v - expected.J_f_v).norm() < 1e-9);
  CHECK((system.J_f_u - expected.J_f_u).norm() < 1e-9);
  CHECK(system.d_v.norm() < 1e-9);
  CHECK((system.phi - expected.phi).norm() < 1e-12);
  CHECK((system.J_n - expected.J_n).norm() < 1e-12);
  CHECK(system.n_e() == 0);
  // and so is the LCS
  const VectorXd stiffness = VectorXd::Constant(2, 50.0);
  const lcs::Lcs lcs = spring_contacts(system, stiffness, 0.01),
                 closed = cart_pole(CartPoleParameters::simulated(), 0.01);
  CHECK((lcs.A - closed.A).norm() < 1e-8);
  CHECK((lcs.D - closed.D).norm() < 1e-8);
  CHECK((lcs.E - closed.E).norm() < 1e-9);
}

TEST_CASE("mechanism: without contact the LCS is MuJoCo's own step, and so are its derivatives") {
  // hinges alone, so that MuJoCo's coordinates are ours
  const test::MjcfFile file(R"(
    <option timestep="0.01"><flag contact="disable"/></option>
    <worldbody>
      <geom name="floor" type="plane" size="1 1 1" pos="0 0 -2"/>
      <body name="a"><joint name="a" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.5"/>
        <body name="b" pos="0.3 0 0"><joint name="b" axis="0 0.6 0.8" stiffness="2" armature="0.01"/>
          <geom type="box" size="0.1 0.02 0.03" pos="0.1 0 0" mass="0.3"/>
          <body name="c" pos="0.2 0 0"><joint name="c" type="slide" axis="1 0.2 0"/>
            <geom name="tip" type="sphere" size="0.02" mass="0.2"/></body></body></body>
    </worldbody>
    <actuator><motor joint="a"/><motor joint="c" gear="2"/></actuator>)");
  const MechanismModel model(parameters(file.path(), {{"tip", "floor"}}));
  std::array<char, 1000> error{};
  const std::unique_ptr<mjModel, void (*)(mjModel*)> mujoco(
      mj_loadXML(file.path().c_str(), nullptr, error.data(), 1000), mj_deleteModel);
  REQUIRE(mujoco);
  const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(mujoco.get()), mj_deleteData);
  const auto step = [&](const VectorXd& x, const VectorXd& u) {
    for (int i = 0; i < 3; ++i) {
      data->qpos[i] = x[i];
      data->qvel[i] = x[3 + i];
    }
    for (int i = 0; i < 2; ++i) data->ctrl[i] = u[i];
    mj_step(mujoco.get(), data.get());
    VectorXd next(6);
    for (int i = 0; i < 3; ++i) {
      next[i] = data->qpos[i];
      next[3 + i] = data->qvel[i];
    }
    return next;
  };
  support::Random random(5);
  for (int i = 0; i < 20; ++i) {
    const VectorXd x = 1.5 * random.vector(6), u = VectorXd::Zero(2);
    const lcs::Lcs lcs = model.planning_system(x, 0.01);
    CHECK((lcs.A * x + lcs.d - step(x, u)).norm() < 1e-9);
    constexpr double kStep = 1e-5;
    for (int axis = 0; axis < 6; ++axis) {
      const VectorXd by = kStep * VectorXd::Unit(6, axis);
      const VectorXd column = (step(x + by, u) - step(x - by, u)) / (2.0 * kStep);
      CHECK((lcs.A.col(axis) - column).norm() < 1e-6);
    }
    for (int axis = 0; axis < 2; ++axis) {
      const VectorXd by = VectorXd::Unit(2, axis);
      CHECK((lcs.B.col(axis) - 0.5 * (step(x, by) - step(x, -by))).norm() < 1e-9);
    }
  }
}

TEST_CASE("mechanism: gaps close at J_n v, between all shapes, and edges move along the surface") {
  const test::MjcfFile file(kShapes);
  const MechanismModel model(parameters(file.path(), of_shapes()));
  const int n_v = model.mechanism().n_v();
  support::Random random(7);
  ContactSystem system, after, before;
  for (int i = 0; i < 20; ++i) {
    VectorXd x = home(model);
    x.head(n_v) += 0.1 * random.vector(n_v);
    model.evaluate(x, system);
    const std::vector<MechanismModel::Contact> contacts = model.contacts();
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < n_v; ++axis) {
      VectorXd up = x, down = x;
      const VectorXd v = VectorXd::Unit(n_v, axis);
      VectorXd q = x.head(n_v);
      scene::move(model.mechanism().coordinates(), v, kStep, q);
      up.head(n_v) = q;
      q = x.head(n_v);
      scene::move(model.mechanism().coordinates(), v, -kStep, q);
      down.head(n_v) = q;
      model.evaluate(up, after);
      model.evaluate(down, before);
      const VectorXd rate = (after.distance - before.distance) / (2.0 * kStep);
      CAPTURE(i, axis, (rate - system.J_n.col(axis)).transpose());
      CHECK((rate - system.J_n.col(axis)).cwiseAbs().maxCoeff() < 1e-5);
    }
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const MechanismModel::Contact& of = contacts[c];
      CHECK((of.p_first - of.p_second - of.distance * of.normal).norm() < 1e-12);
      CHECK(std::abs(of.normal.dot(of.t)) + std::abs(of.normal.dot(of.s)) < 1e-12);
      CHECK(of.t.norm() == Approx(1.0));
      CHECK(of.s.norm() == Approx(1.0));
    }
  }
}

TEST_CASE("mechanism: every block is that of finite differences of the step") {
  const test::MjcfFile file(kShapes);
  for (const ContactModel contact_model :
       {ContactModel::kAnitescu, ContactModel::kStewartTrinkle}) {
    for (const int directions : {1, 2, 3}) {
      MechanismParameters p = parameters(file.path(), of_shapes());
      p.contact_model = contact_model;
      p.directions = directions;
      const MechanismModel model(p);
      CAPTURE(directions, static_cast<int>(contact_model));
      // not at home, where an arm that is parallel to a box is nearest all along it
      support::Random random(11);
      VectorXd x = home(model);
      x.head(x.size() / 2) += 0.05 * random.vector(x.size() / 2);
      const BlockErrors at_rest = block_errors(model, x, 0.02);
      for (const double error : {at_rest.A, at_rest.B, at_rest.D, at_rest.F, at_rest.H})
        CHECK(error < 1e-6);
      CHECK(at_rest.d < 1e-9);
      CHECK(at_rest.c < 1e-9);
      // normals and lever arms turn with what they belong to, which one linearisation leaves out
      CHECK(at_rest.E < 0.5);
      x.tail(x.size() / 2) = 0.05 * random.vector(x.size() / 2);
      const BlockErrors moving = block_errors(model, x, 0.02);
      CHECK(moving.A < 0.02);
      for (const double error : {moving.B, moving.D, moving.F, moving.H}) CHECK(error < 0.01);
      CHECK(moving.c < 1e-7);
    }
  }
}

TEST_CASE("mechanism: closest keeps the nearest ones, and without it all are kept") {
  const test::MjcfFile file(kShapes);
  const MechanismModel all(parameters(file.path(), {{"lower", "jack"}})),
      one(parameters(file.path(), {{"lower", "jack", 1}})),
      more(parameters(file.path(), {{"lower", "jack", 99}}));
  CHECK(all.n_c() == 4);  // two geoms with two
  CHECK(one.n_c() == 1);
  CHECK(more.n_c() == 4);
  support::Random random(3);
  ContactSystem of_all, of_one;
  for (int i = 0; i < 20; ++i) {
    VectorXd x = home(all);
    x.head(x.size() / 2) += 0.5 * random.vector(x.size() / 2);
    all.evaluate(x, of_all);
    one.evaluate(x, of_one);
    CHECK(of_one.distance[0] == of_all.distance.minCoeff());
  }
}

TEST_CASE("mechanism: a name is a geom's, a body's or the world's, and a wrong one names those") {
  const test::MjcfFile file(kShapes);
  const auto model = [&](const std::string& first, const std::string& second) {
    return MechanismModel(parameters(file.path(), {{first, second}})).n_c();
  };
  CHECK(model("tip", "can") == 1);
  CHECK(model("lower", "can") == 2);
  CHECK(model("world", "tip") == 2);  // the step, and one point on the wall
  CHECK(model("wall", "arm") == 2);   // a capsule's ends
  CHECK(model("step", "jack") == 2);
  CHECK_THROWS_WITH(model("tip", "tin"), Contains("got \"tin\"") && Contains("can") &&
                                             Contains("step") && Contains("world"));
  CHECK_THROWS_WITH(model("tip", "finger"), Contains("expected two that can touch"));
  CHECK_THROWS_WITH(model("wall", "step"), Contains("expected two that can touch"));
  CHECK_THROWS_WITH(MechanismModel(parameters(file.path(), {})), Contains("between"));
  CHECK_THROWS_WITH(MechanismModel(parameters(file.path(), {{"tip", "can", 0, -1.0}})),
                    Contains("friction"));
  MechanismParameters p = parameters(file.path(), {{"tip", "can"}});
  p.directions = 9;
  CHECK_THROWS_WITH(MechanismModel(p), Contains("0 to 8 directions"));
}

TEST_CASE("mechanism: friction is the rougher surface's, and its first direction as asked for") {
  const test::MjcfFile file(kShapes);
  MechanismParameters p = parameters(kPusher, {{"left", "disc"}, {"disc", "floor"}});
  const Vector3d across(0.3, 0.1, 1.0);
  p.across = across;
  const MechanismModel model(p);
  ContactSystem system;
  model.evaluate(home(model), system);
  CHECK(system.mu[0] == 0.5);
  CHECK(system.mu.tail(4) == VectorXd::Constant(4, 0.4));
  CHECK(std::abs(model.contacts()[0].t.dot(across)) < 1e-12);
}

TEST_CASE("mechanism: what a motor moves touches a body that it overlaps, and tells by how much") {
  const MechanismModel model(parameters(kPusher, {{"left", "disc"}, {"disc", "floor"}}));
  VectorXd x = home(model);
  x[0] = 0.03;
  ContactSystem system;
  model.evaluate(x, system);
  CHECK(system.phi[0] == 0.0);
  CHECK(system.distance[0] == Approx(std::hypot(0.07, 0.02) - 0.075).margin(1e-9));
  // a disc in the floor is out of it in the next step
  x[4] -= 0.001;
  model.evaluate(x, system);
  CHECK(system.phi[1] == Approx(-0.001));
}

TEST_CASE("mechanism: after the first evaluation none takes from the heap") {
  const test::MjcfFile file(kShapes);
  const MechanismModel model(parameters(file.path(), of_shapes()));
  const VectorXd x = home(model);
  ContactSystem system;
  LcsStorage storage;
  lcs::Lcs lcs;
  model.evaluate(x, system);
  to_lcs(ContactModel::kAnitescu, system, 0.05, storage, lcs);
  std::int64_t calls = 0;
  {
    const support::AllocationCounter heap;
    for (int i = 0; i < 5; ++i) {
      model.evaluate(x, system);
      to_lcs(ContactModel::kAnitescu, system, 0.05, storage, lcs);
    }
    calls = heap.count();
  }
  CHECK(calls == 0);
}

TEST_CASE("mechanism: x, u and forces have the names of joints, bodies and motors; u its range") {
  MechanismParameters p = parameters(kPusher, {{"left", "disc"}, {"disc", "floor"}});
  p.contact_model = ContactModel::kStewartTrinkle;
  p.directions = 1;
  const MechanismModel model(p);
  const SystemLayout& layout = model.layout();
  CHECK(layout.n_x() == 16);
  CHECK(layout.n_u() == 2);
  CHECK(layout.n_lambda() == 5 * 4);
  CHECK(layout.x[0].name == "fork_x");
  CHECK(layout.x[8].name == "fork_x_rate");
  CHECK(layout.x[2].name == "disc_x");
  CHECK(layout.x[7].unit == "rad");
  CHECK(layout.u[1].name == "force_y");
  CHECK(layout.lambda[0].name == "left_disc_gamma");
  CHECK(layout.lambda[5].name == "left_disc_normal");
  CHECK(layout.lambda[11].name == "left_disc_edge_2");
  CHECK(layout.lambda[12].name == "disc_floor_1_edge_1");
  VectorXd u = Eigen::Vector2d(-30.0, 7.0);
  model.clip(u);
  CHECK(u == Eigen::Vector2d(-20.0, 7.0));
}
