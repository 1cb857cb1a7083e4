#include "controller/model/objects_model.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <mujoco/mujoco.h>

#include "controller/lcs/lemke.hpp"
#include "controller/lcs/step.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/model/pushed_box.hpp"
#include "controller/scene/distance.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using namespace c3rt::model;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using L = ObjectsLayout;

namespace {

const std::string kObjects = C3RT_SOURCE_DIRECTORY "/config/objects/";
constexpr double kRadius = 0.0195, kTableHeight = -0.02, kStep = 1e-6;

scene::Object object(const std::string& name) {
  return mjcf::read_object(kObjects + name + ".xml").object;
}

/// Three capsules across each other.
scene::Object jack() {
  scene::Union parts;
  const scene::Shape bar = scene::Shape::capsule(0.015, 0.05);
  const auto turned = [](const Vector3d& axis) {
    return Eigen::AngleAxisd(0.5 * M_PI, axis).toRotationMatrix();
  };
  parts.parts = {{bar, Vector3d::Zero()},
                 {bar, Vector3d::Zero(), turned(Vector3d::UnitX())},
                 {bar, Vector3d::Zero(), turned(Vector3d::UnitY())}};
  return scene::make_object("jack", 0.3, 2e-4 * Matrix3d::Identity(), 0.4, parts);
}

ObjectsParameters parameters(std::vector<scene::Object> objects) {
  return {1.0, kRadius, kTableHeight, 0.5, 0.4, 0.3, 4, false, std::move(objects)};
}

/// The objects in the air, turned and turning anyhow, and the end effector outside them.
scene::Scene anywhere(const PlanningModel& model, unsigned seed) {
  support::Random random(seed);
  scene::Scene scene = model.layout().world;
  for (int i = 0; i < scene.body_count; ++i) {
    scene::Body& body = scene.body(i);
    body.p_WB = Vector3d(0.5, 0.3 * i, 0.1) + 0.05 * random.vector(3);
    body.q_WB = Eigen::Quaterniond(Eigen::Vector4d(random.vector(4)).normalized());
    body.v_WB = random.vector(3);
    body.omega_WB = 3.0 * random.vector(3);
  }
  scene.effector.v_WE = random.vector(3);
  double nearest = 0.0;
  do {
    scene.effector.p_WE = scene.body(0).p_WB + 0.25 * random.vector(3);
    nearest = 1.0;
    for (int i = 0; i < scene.body_count; ++i)
      nearest = std::min(nearest, scene::gap(scene.effector, scene.body(i)).distance);
  } while (nearest < 5e-3);
  return scene;
}

VectorXd velocities(const scene::Scene& scene) {
  VectorXd v(3 + 6 * scene.body_count);
  v.head<3>() = scene.effector.v_WE;
  for (int i = 0; i < scene.body_count; ++i)
    v.segment<6>(3 + 6 * i) << scene.body(i).v_WB, scene.body(i).omega_WB;
  return v;
}

VectorXd state(const PlanningModel& model, const scene::Scene& scene) {
  VectorXd x(model.layout().n_x);
  model.state(scene, x);
  return x;
}

/// Each object of these alone, two, and four of them.
std::vector<std::unique_ptr<PlanningModel>> models() {
  std::vector<std::unique_ptr<PlanningModel>> result;
  for (const auto& objects :
       {std::vector{object("t")}, std::vector{jack()}, std::vector{object("t"), object("box")},
        std::vector{object("t"), jack(), object("box"), object("t")}})
    result.push_back(make_objects_model(parameters(objects)));
  return result;
}

int count_of(const Layout& layout, const std::string& pair) {
  int count = 0;
  for (const ModelContact& contact : layout.contacts) count += contact.pair == pair;
  return count;
}

}  // namespace

TEST_CASE("objects: sizes and contacts are those of so many objects") {
  for (int n = 1; n <= 4; ++n) {
    ObjectsParameters p =
        parameters(std::vector<scene::Object>(static_cast<std::size_t>(n), object("t")));
    const auto model = make_objects_model(p);
    const Layout& layout = model->layout();
    CHECK(layout.n_x == 6 + 12 * n);
    CHECK(count_of(layout, "end_effector_object") == 1);
    CHECK(count_of(layout, "object_table") == 4 * n);
    CHECK(count_of(layout, "object_object") == n * (n - 1) / 2);
    p.each_object = true;
    p.support_points = 3;
    const auto with_each = make_objects_model(p);
    CHECK(count_of(with_each->layout(), "end_effector_object") == n);
    CHECK(count_of(with_each->layout(), "object_table") == 3 * n);
  }
  CHECK_THROWS_WITH(make_objects_model(parameters({})), Catch::Contains("expected 1 to 4"));
  ObjectsParameters p = parameters({object("t")});
  p.support_points = 5;
  CHECK_THROWS_WITH(make_objects_model(p), Catch::Contains("expected 3 or 4"));
}

TEST_CASE("objects: a box from its file is the pushed box, to rounding") {
  const auto box =
      make_pushed_box({1.0, kRadius, 0.5, Vector3d(0.05, 0.05, 0.03), kTableHeight, 0.5, 0.4});
  const auto model = make_objects_model(parameters({object("box")}));
  // the pushed box has its corners in another order
  const std::vector<int> not_the_table{0};
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const scene::Scene scene = anywhere(*model, seed);
    const ContactSystem one = model->contact_system(scene, not_the_table),
                        other = box->contact_system(scene, not_the_table);
    CHECK((state(*model, scene) - state(*box, scene)).norm() < 1e-12);
    CHECK((one.M_inverse - other.M_inverse).norm() < 1e-9 * other.M_inverse.norm());
    CHECK((one.J_f_q - other.J_f_q).norm() < 1e-9 * (1.0 + other.J_f_q.norm()));
    CHECK((one.J_f_v - other.J_f_v).norm() < 1e-9 * (1.0 + other.J_f_v.norm()));
    CHECK((one.d_v - other.d_v).norm() < 1e-9 * other.d_v.norm());
    CHECK((one.J_n - other.J_n).norm() < 1e-12);
    CHECK((one.J_t - other.J_t).norm() < 1e-12);
    CHECK(one.phi[0] == Approx(other.phi[0]));
  }
}

TEST_CASE("objects: mass matrix and bias are MuJoCo's") {
  for (const char* name : {"t", "box"}) {
    const std::string file = kObjects + name + ".xml";
    const mjcf::ObjectFile read = mjcf::read_object(file);
    std::array<char, 1000> error{};
    const std::unique_ptr<mjModel, void (*)(mjModel*)> mujoco(
        mj_loadXML(file.c_str(), nullptr, error.data(), 1000), mj_deleteModel);
    REQUIRE(mujoco);
    const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(mujoco.get()), mj_deleteData);
    const auto model = make_objects_model(parameters({read.object}));
    for (unsigned seed = 1; seed <= 100; ++seed) {
      CAPTURE(name, seed);
      const scene::Scene scene = anywhere(*model, seed);
      const scene::Body& body = scene.body(0);
      const Eigen::Quaterniond q_WB = body.q_WB;
      const Matrix3d R = q_WB.toRotationMatrix();
      const Vector3d omega = body.omega_WB;
      // MuJoCo's place and velocity are those of the body's origin, its ω is in the body's axes
      const Vector3d to_origin = -R * read.p_body_com;
      const Vector3d p = body.p_WB + to_origin, v = body.v_WB + omega.cross(to_origin);
      for (int i = 0; i < 3; ++i) {
        data->qpos[i] = p[i];
        data->qvel[i] = v[i];
        data->qvel[3 + i] = (R.transpose() * omega)[i];
      }
      data->qpos[3] = q_WB.w();
      data->qpos[4] = q_WB.x();
      data->qpos[5] = q_WB.y();
      data->qpos[6] = q_WB.z();
      mj_fwdPosition(mujoco.get(), data.get());
      mj_fwdVelocity(mujoco.get(), data.get());
      Eigen::Matrix<double, 6, 6, Eigen::RowMajor> M;
      mj_fullM(mujoco.get(), M.data(), data->qM);
      const Eigen::Matrix<double, 6, 1> bias =
          Eigen::Map<Eigen::Matrix<double, 6, 1>>(data->qfrc_bias);

      const ContactSystem system = model->contact_system(scene, {0});
      Eigen::Matrix<double, 6, 6> T = Eigen::Matrix<double, 6, 6>::Zero();
      T.topLeftCorner<3, 3>().setIdentity();
      for (int i = 0; i < 3; ++i) T.col(3 + i).head<3>() = Vector3d::Unit(i).cross(to_origin);
      T.bottomRightCorner<3, 3>() = R.transpose();
      const Eigen::Matrix<double, 6, 6> of_mujoco = T.transpose() * M * T;
      CHECK((of_mujoco * system.M_inverse.bottomRightCorner<6, 6>() -
             Eigen::Matrix<double, 6, 6>::Identity())
                .cwiseAbs()
                .maxCoeff() < 1e-12);
      // M v̇ + bias = 0 with v̇ of the origin
      const VectorXd f = (system.J_f_v * velocities(scene) + system.d_v).tail(6);
      Eigen::Matrix<double, 6, 1> accelerated = T * f;
      accelerated.head<3>() += omega.cross(omega.cross(to_origin));
      CHECK((M * accelerated + bias).cwiseAbs().maxCoeff() < 1e-12);
    }
  }
}

TEST_CASE("objects: gaps and their rates are those of finite differences") {
  for (const auto& model : models()) {
    const std::vector<int> all = all_contacts(model->layout());
    for (unsigned seed = 1; seed <= 30; ++seed) {
      CAPTURE(seed, model->layout().n_x);
      const scene::Scene here = anywhere(*model, seed);
      const ContactSystem system = model->contact_system(here, all);
      for (int i = 0; i < model->layout().n_v; ++i) {
        const VectorXd v = VectorXd::Unit(model->layout().n_v, i);
        const VectorXd after = model->contact_system(moved(here, v, kStep), all).phi;
        const VectorXd before = model->contact_system(moved(here, v, -kStep), all).phi;
        const VectorXd rate = (after - before) / (2.0 * kStep);
        REQUIRE((rate - system.J_n.col(i)).cwiseAbs().maxCoeff() < 1e-5);
      }
    }
  }
}

TEST_CASE("objects: gaps are those of their shapes, with the nearest object, point by point") {
  for (const auto& model : models()) {
    const Layout& layout = model->layout();
    for (unsigned seed = 1; seed <= 30; ++seed) {
      const scene::Scene here = anywhere(*model, seed);
      const ContactSystem system = model->contact_system(here, all_contacts(layout));
      double nearest = 1.0, lowest = 1.0, lowest_contact = 1.0;
      for (int i = 0; i < here.body_count; ++i)
        nearest = std::min(nearest, scene::gap(here.effector, here.body(i)).distance);
      CHECK(system.phi[0] == Approx(nearest));
      for (int c = 0; c < layout.n_c(); ++c) {
        const ModelContact& contact = layout.contacts[static_cast<std::size_t>(c)];
        if (contact.pair == "object_table" && contact.bodies.first == 0)
          lowest_contact = std::min(lowest_contact, system.phi[c]);
        if (contact.pair != "object_object") continue;
        const scene::Body &a = here.body(contact.bodies.first),
                          &b = here.body(contact.bodies.second);
        const auto place = [](const scene::Body& body) {
          return scene::Place{body.p_WB, Eigen::Quaterniond(body.q_WB).toRotationMatrix()};
        };
        CHECK(system.phi[c] ==
              Approx(scene::separation(a.shape, place(a), b.shape, place(b)).distance));
      }
      // no point of the first object is lower than its lowest support point
      const scene::Body& body = here.body(0);
      const Vector3d down =
          Eigen::Quaterniond(body.q_WB).conjugate() * Vector3d(-Vector3d::UnitZ());
      lowest = body.p_WB.z() - scene::reach(body.shape, down) - kTableHeight;
      CHECK(lowest_contact >= lowest - 1e-9);
      // the face that looks down the most need not have the lowest corner, but one near it
      CHECK(lowest_contact < lowest + 0.05);
    }
  }
}

TEST_CASE("objects: an end effector that overlaps a body touches it") {
  const auto box =
      make_pushed_box({1.0, kRadius, 0.5, Vector3d(0.05, 0.05, 0.03), kTableHeight, 0.5, 0.4});
  const auto model = make_objects_model(parameters({object("box")}));
  scene::Scene scene = model->layout().world;
  scene.body(0).p_WB = Vector3d(0.5, 0.0, 0.01);
  for (const double overlap : {0.008, 1e-6, 0.0, -0.008}) {
    CAPTURE(overlap);
    scene.effector.p_WE = Vector3d(0.45 - kRadius + overlap, 0.01, 0.01);
    for (const PlanningModel* of : {box.get(), model.get()}) {
      const ContactSystem system = of->contact_system(scene, {0});
      CHECK(system.phi[0] == Approx(std::max(0.0, -overlap)).margin(1e-12));
      CHECK(system.distance[0] == Approx(-overlap).margin(1e-12));
      // they come apart when the end effector goes back
      CHECK((system.J_n.row(0).head(3) - Eigen::RowVector3d(-1.0, 0.0, 0.0)).norm() < 1e-9);
    }
  }
}

TEST_CASE("objects: lying flat, the support points are spread around the centre of mass") {
  for (const char* name : {"t", "box"}) {
    for (const int count : {3, 4}) {
      ObjectsParameters p = parameters({object(name)});
      p.support_points = count;
      const auto model = make_objects_model(p);
      for (double yaw = 0.0; yaw < 6.2; yaw += 0.7) {
        scene::Scene scene = model->layout().world;
        scene.body(0).q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
        const double height = scene::reach(scene.body(0).shape, -Vector3d::UnitZ());
        scene.body(0).p_WB << 0.5, 0.1, kTableHeight + height;
        scene.effector.p_WE << 0.2, 0.0, 0.1;
        const ContactSystem system = model->contact_system(scene, all_contacts(model->layout()));
        CHECK(system.phi.tail(count).cwiseAbs().maxCoeff() < 1e-9);
        // a positive sum of the arms is 0: J_n has them as torques about x and y
        const MatrixXd arms = system.J_n.block(1, L::rotation(0), count, 2);
        double most = -1.0;  // over directions, how little the farthest point is out
        for (double way = 0.0; way < 6.3; way += 0.1) {
          const double out = (arms * Eigen::Vector2d(std::cos(way), std::sin(way))).maxCoeff();
          most = most < 0.0 ? out : std::min(most, out);
        }
        CHECK(most > 0.01);
      }
    }
  }
}

TEST_CASE("objects: every block of the LCS is that of the step, to the rank that it is linear in") {
  for (const auto& model : models()) {
    const std::vector<int> all = all_contacts(model->layout());
    for (const ContactModel contact_model :
         {ContactModel::kAnitescu, ContactModel::kStewartTrinkle}) {
      for (unsigned seed = 1; seed <= 5; ++seed) {
        CAPTURE(seed, model->layout().n_x);
        scene::Scene scene = anywhere(*model, seed);
        const BlockErrors moving = block_errors(*model, contact_model, scene, all, 0.05);
        // inputs and forces enter in a straight line, and so do the values here
        CHECK(moving.B < 1e-7);
        CHECK(moving.H < 1e-7);
        CHECK(moving.F < 1e-7);
        // the turn by Δt ω is not the turn of a sum: of second order in it
        CHECK(moving.d < 0.05);
        CHECK(moving.c < 1e-9);
        for (int i = 0; i < scene.body_count; ++i) {
          scene.body(i).v_WB.setZero();
          scene.body(i).omega_WB.setZero();
        }
        scene.effector.v_WE.setZero();
        const BlockErrors resting = block_errors(*model, contact_model, scene, all, 0.05);
        CHECK(resting.A < 1e-6);
        CHECK(resting.D < 1e-6);
        CHECK(resting.d < 1e-9);
        CHECK(resting.c < 1e-9);
      }
    }
  }
}

TEST_CASE(
    "objects: with a damping of 1/step they move only as they are pushed, as far as least energy") {
  // without friction and gravity's part: v = M^-1 J_n' lambda with J_n v = that of the end effector
  const double step = 0.05;
  ObjectsParameters p = parameters({object("t")});
  p.friction_end_effector = p.friction_table = 0.0;
  p.damping = 1.0 / step;
  const auto model = make_objects_model(p);
  scene::Scene scene = model->layout().world;
  scene.body(0).p_WB << 0.5, 0.0,
      kTableHeight + scene::reach(scene.body(0).shape, -Vector3d::UnitZ());
  scene.body(0).v_WB << 0.3, -0.2, 0.0;
  scene.body(0).omega_WB << 0.0, 0.0, 2.0;
  scene.effector.p_WE = scene.body(0).p_WB + Vector3d(-0.15, 0.03, 0.0);
  const scene::Gap gap = scene::gap(scene.effector, scene.body(0));
  scene.effector.p_WE -= gap.distance * gap.normal;
  for (const Vector3d& v_WE : {Vector3d(0.0, 0.0, 0.0), Vector3d(0.1, 0.02, 0.0)}) {
    scene.effector.v_WE = v_WE;
    const ContactSystem contacts = model->contact_system(scene, all_contacts(model->layout()));
    const lcs::Lcs system = stewart_trinkle(contacts, step);
    lcs::Lemke lemke(static_cast<int>(system.F.rows()));
    VectorXd next(model->layout().n_x), lambda(lemke.size());
    REQUIRE(lcs::step(system, state(*model, scene), Vector3d::Zero(), lemke, next, lambda).ok());
    const auto v = next.tail(model->layout().n_v);
    const Vector3d normal = contacts.J_n.row(0).head<3>().transpose();
    // the end effector of 1 kg meets the object with its speed along the normal; after it both have
    // one speed there, by the mass that each of them has at the contact
    const Eigen::VectorXd of_object = contacts.J_n.row(0).segment(3, 6).transpose();
    const double give = of_object.dot(contacts.M_inverse.block<6, 6>(3, 3) * of_object);
    const double impulse = std::max(0.0, -normal.dot(v_WE)) / (1.0 + give);
    const Eigen::VectorXd expected = contacts.M_inverse.block<6, 6>(3, 3) * of_object * impulse;
    CHECK((v.segment<2>(3) - expected.head<2>()).norm() < 1e-9);
    CHECK(v[8] == Approx(expected[5]).margin(1e-9));
  }
}

TEST_CASE("objects: at rest they lie still, and sliding they slow down by mu g") {
  for (const char* name : {"t", "box"}) {
    const auto model = make_objects_model(parameters({object(name)}));
    const std::vector<int> all = all_contacts(model->layout());
    scene::Scene scene = model->layout().world;
    scene.body(0).p_WB << 0.5, 0.0,
        kTableHeight + scene::reach(scene.body(0).shape, -Vector3d::UnitZ());
    scene.effector.p_WE << 0.2, 0.0, 0.1;
    for (const ContactModel contact_model :
         {ContactModel::kStewartTrinkle, ContactModel::kAnitescu}) {
      for (const double speed : {0.0, 0.3}) {
        scene.body(0).v_WB = speed * Vector3d(0.6, 0.8, 0.0);
        const lcs::Lcs system = to_lcs(contact_model, model->contact_system(scene, all), 0.01);
        lcs::Lemke lemke(static_cast<int>(system.F.rows()));
        VectorXd next(model->layout().n_x), lambda(lemke.size());
        REQUIRE(
            lcs::step(system, state(*model, scene), Vector3d::Zero(), lemke, next, lambda).ok());
        const Vector3d after = next.segment<3>(model->layout().n_v + L::position(0));
        const double slowed = (scene.body(0).v_WB - after).norm() / 0.01;
        if (speed == 0.0) {
          CHECK((next - state(*model, scene)).norm() < 1e-9);
        } else if (contact_model == ContactModel::kStewartTrinkle) {
          CHECK(slowed < 1.001 * 0.4 * 9.81);
          CHECK(slowed > 0.8 * 0.4 * 9.81);
        }
      }
    }
  }
}

TEST_CASE("objects: of many the one that is nearest and its neighbour are the model of these two") {
  const std::vector<scene::Object> all{object("t"), object("box"), object("l"), object("h")};
  ObjectsParameters p = parameters(all);
  p.closest = 2;
  const auto model = make_objects_model(p);
  CHECK(model->layout().n_x == 30);
  CHECK(model->layout().world.body_count == 4);
  scene::Scene scene = model->layout().world;
  const Vector3d at[] = {{0.5, 0.2, 0.0}, {0.5, -0.2, 0.0}, {0.7, 0.15, 0.0}, {0.65, -0.2, 0.0}};
  for (int i = 0; i < 4; ++i) {
    scene.body(i).p_WB = at[i];
    scene.body(i).q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * i, Vector3d::UnitZ()));
    scene.body(i).v_WB = Vector3d(0.1, 0.0, 0.01 * i);
  }
  struct Case {
    Vector3d p_WE;
    int first, second;
  };
  for (const Case& c : {Case{{0.65, 0.15, 0.0}, 0, 2}, Case{{0.4, -0.2, 0.0}, 1, 3},
                        Case{{0.75, -0.2, 0.0}, 1, 3}}) {
    CAPTURE(c.p_WE.transpose());
    scene.effector.p_WE = c.p_WE;
    CHECK(model->body(0, scene) == c.first);
    CHECK(model->body(1, scene) == c.second);
    const auto of = [&](int i) { return all[static_cast<std::size_t>(i)]; };
    const auto two = make_objects_model(parameters({of(c.first), of(c.second)}));
    scene::Scene pair = two->layout().world;
    pair.effector = scene.effector;
    for (const int i : {0, 1}) {
      const scene::Shape shape = pair.body(i).shape;
      pair.body(i) = scene.body(i == 0 ? c.first : c.second);
      pair.body(i).shape = shape;
    }
    VectorXd x(30), x_two(30);
    model->state(scene, x);
    two->state(pair, x_two);
    CHECK(x == x_two);
    REQUIRE(model->layout().n_c() == two->layout().n_c());
    const ContactSystem a = model->contact_system(scene, all_contacts(model->layout()));
    const ContactSystem b = two->contact_system(pair, all_contacts(two->layout()));
    CHECK(a.phi == b.phi);
    CHECK(a.J_n == b.J_n);
    CHECK(a.J_t == b.J_t);
    CHECK(a.M_inverse == b.M_inverse);
    CHECK(a.d_v == b.d_v);
    // what is wanted is that of the same two, wherever the end effector is wanted
    scene::Scene wanted = scene;
    wanted.effector.p_WE = -c.p_WE;
    wanted.body(c.second).p_WB.x() += 0.1;
    model->state_about(wanted, scene, x_two);
    CHECK(x_two[L::position(1)] == Approx(scene.body(c.second).p_WB.x() + 0.1));
  }
  p.closest = 5;
  CHECK_THROWS_WITH(make_objects_model(p), Catch::Contains("4 of them or fewer"));
}

TEST_CASE("objects: contact system and LCS need no heap after the first") {
  for (const auto& model : models()) {
    const std::vector<int> all = all_contacts(model->layout());
    for (const ContactModel contact_model :
         {ContactModel::kAnitescu, ContactModel::kStewartTrinkle}) {
      ContactSystem system;
      LcsStorage storage;
      lcs::Lcs lcs;
      std::int64_t heap_calls = 0;
      for (unsigned seed = 1; seed <= 3; ++seed) {
        const scene::Scene scene = anywhere(*model, seed);
        const support::AllocationCounter heap;
        model->evaluate(scene, all, system);
        to_lcs(contact_model, system, 0.05, storage, lcs);
        if (seed > 1) heap_calls += heap.count();
      }
      CHECK(heap_calls == 0);
      const lcs::Lcs anew = to_lcs(contact_model, system, 0.05);
      CHECK(lcs.A == anew.A);
      CHECK(lcs.D == anew.D);
      CHECK(lcs.E == anew.E);
      CHECK(lcs.F == anew.F);
      CHECK(lcs.c == anew.c);
    }
  }
}
