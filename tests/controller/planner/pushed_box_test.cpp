// A new body is a model: Algorithm 3 pushes a box that no other file knows.
#include "controller/model/pushed_box.hpp"

#include <catch2/catch.hpp>

#include "controller/lcs/step.hpp"
#include "controller/planner/c3_controller.hpp"

using namespace c3rt;
using namespace c3rt::planner;
using Eigen::Vector3d;
using L = model::PushedBoxLayout;

namespace {

const model::PushedBoxParameters kBox{1.0, 0.0195, 0.5, {0.05, 0.05, 0.03}, 0.0, 0.5, 0.4};

/// C3+ with physical units, two iterations.
Parameters parameters() {
  Parameters p{};
  p.rate = 50.0;
  p.N = 10;
  p.dt = 0.05;
  p.scale_forces = false;
  p.model.kind = "pushed_box";
  p.model.bodies = 1;
  p.model.contact_model = model::ContactModel::kAnitescu;
  p.model.pairs = {"end_effector_box", "box_table"};
  p.c3.admm_iterations = 2;
  p.c3.rho = 1.0;
  p.c3.rho_scale = 3.0;
  p.c3.qp = c3::QpBackend::kDirect;
  p.c3.projection = c3::ProjectionKind::kPlus;
  p.c3.max_nodes = 1;
  p.c3.delta_starts_at_x0 = true;
  PhaseWeights& w = p.roll;
  w.Q = {{"end_effector_xy", {1e-4}}, {"end_effector_z", {10.0}},
         {"box_xy", {1.0}},           {"box_z", {0.0}},
         {"box_rotation", {0.05}},    {"end_effector_velocity", {0.02}},
         {"box_velocity", {1e-4}},    {"box_angular_velocity", {1e-5}}};
  w.R = 1e-5;
  w.G_x = w.G_u = 1e-6;
  w.G_lambda = {{"gamma", 0.1},
                {"end_effector_normal", 0.1},
                {"end_effector_tangential", 0.1},
                {"table_normal", 0.1},
                {"table_tangential", 0.1}};
  w.U_x = w.U_lambda = w.U_u = 1.0;
  w.of_projections["plus"] = {
      {"u_lambda", {10.0, 10.0, 10.0}}, {"g_eta", {0.01, 0.01, 0.01}}, {"u_eta", {1.0, 1.0, 1.0}}};
  return p;
}

/// The scene that a state of the model stands for.
void take(const Eigen::VectorXd& x, scene::Scene& scene) {
  scene::Body& box = scene.body(0);
  scene.effector.p_WE = x.segment<3>(L::p_WE);
  scene.effector.v_WE = x.segment<3>(L::v_WE);
  box.p_WB = x.segment<3>(L::p_WB);
  box.v_WB = x.segment<3>(L::v_WB);
  box.omega_WB = x.segment<3>(L::omega_WB);
  const Vector3d turn = x.segment<3>(L::rotation);
  if (turn.norm() > 0.0) {
    const Eigen::Quaterniond q_WB = box.q_WB;
    box.q_WB =
        (Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * q_WB).normalized();
  }
}

}  // namespace

TEST_CASE("pushed box: C3+ pushes it along from behind, in any direction of the table") {
  for (const double heading : {0.0, 0.5 * M_PI, M_PI}) {
    CAPTURE(heading);
    const Parameters p = parameters();
    C3Controller c3(p, model::make_pushed_box(kBox));
    const int costs = c3.add_costs(costs_of(c3.problem(), p.roll));
    const model::PlanningModel& model = c3.model();
    const std::vector<int> all = model::all_contacts(model.layout());
    const Vector3d way(std::cos(heading), std::sin(heading), 0.0);

    scene::Scene scene = model.layout().world;
    scene::Body& box = scene.body(0);
    box.p_WB << 0.5, 0.0, kBox.half_sizes.z();
    const Vector3d start = box.p_WB;
    // 5 mm behind it, at the height of its middle
    scene.effector.p_WE = box.p_WB - (kBox.half_sizes.x() + 0.0195 + 0.005) * way;
    const double height = scene.effector.p_WE.z();

    constexpr double kStep = 0.005;
    lcs::Lemke lemke(c3.n_lambda_d());
    Eigen::VectorXd x(L::n_x), next(L::n_x), lambda(c3.n_lambda_d());
    Vector3d u = Vector3d::Zero();
    int failures = 0;
    for (int step = 0; step < 800; ++step) {
      if (step % 4 == 0) {  // 50 Hz
        scene::Scene wanted = scene;
        wanted.body(0).p_WB = start + 0.15 * way;
        // no farther than a tenth of a metre from where it is
        const Vector3d ahead = wanted.body(0).p_WB - box.p_WB;
        if (ahead.norm() > 0.1) wanted.body(0).p_WB = box.p_WB + 0.1 * ahead.normalized();
        wanted.body(0).q_WB.setIdentity();
        wanted.body(0).v_WB.setZero();
        wanted.body(0).omega_WB.setZero();
        wanted.effector.p_WE.z() = height;
        wanted.effector.v_WE.setZero();
        for (int k = 0; k <= p.N; ++k) c3.want(k, wanted, scene);
        const StepStatus status = c3.step(scene, costs, 0.02, {});
        failures += status == StepStatus::kOk ? 0 : 1;
        if (status != StepStatus::kFailed) u = c3.result().u_c3;
      }
      const lcs::Lcs plant = model::stewart_trinkle(model.contact_system(scene, all), kStep);
      model.state(scene, x);
      REQUIRE(lcs::step(plant, x, u, lemke, next, lambda).ok());
      take(next, scene);
      REQUIRE(next.allFinite());
    }
    CHECK(failures == 0);
    const Vector3d moved = box.p_WB - start;
    CHECK(moved.dot(way) > 0.12);
    CHECK(moved.dot(way) < 0.18);
    CHECK((moved - moved.dot(way) * way).norm() < 0.02);
    // one place to push at cannot hold its heading for good: to change the place is a sampling
    // strategy's
    CHECK(std::abs(scene::yaw(box)) < 0.3);
  }
}
