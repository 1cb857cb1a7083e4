#include "controller/model/planning_model.hpp"

#include <set>

#include <catch2/catch.hpp>

#include "controller/model/registry.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

scene::Object box() {
  scene::Union parts;
  parts.parts.push_back({scene::Shape::box({0.05, 0.04, 0.03})});
  return scene::make_object("box", 0.5, 0.001 * Eigen::Matrix3d::Identity(), 0.4, parts);
}

/// Every kind with numbers within its ranges, and every count of bodies that it is for.
std::vector<std::unique_ptr<model::PlanningModel>> all_models() {
  std::vector<std::unique_ptr<model::PlanningModel>> models;
  for (const model::ModelKind& kind : model::model_kinds()) {
    for (int bodies = kind.min_bodies; bodies <= kind.max_bodies; ++bodies) {
      model::ModelValues values;
      for (const model::ModelKey& key : kind.keys) {
        if (key.names_objects) {
          values.set_objects({static_cast<std::size_t>(bodies), box()});
        } else {
          values.set(key.name, std::min(std::max(0.05, key.min), key.max));
        }
      }
      models.push_back(kind.make(values, bodies));
    }
  }
  return models;
}

/// Bodies apart from each other, the end effector above the first.
scene::Scene some_scene(support::Random& random) {
  scene::Scene scene;
  scene.body_count = scene::kMaxBodies;
  for (int i = 0; i < scene::kMaxBodies; ++i) {
    scene.body(i).p_WB = {0.4 + 0.2 * i, random.uniform(), 0.1};
    scene.body(i).v_WB = random.vector(3);
    scene.body(i).omega_WB = random.vector(3);
  }
  scene.effector.p_WE = scene.body(0).p_WB + Vector3d(0.02, 0.01, 0.12);
  scene.effector.v_WE = random.vector(3);
  return scene;
}

}  // namespace

TEST_CASE(
    "planning models: every entry of x belongs to one block, and blocks to bodies that there are") {
  for (const auto& model : all_models()) {
    const model::Layout& layout = model->layout();
    std::vector<int> owners(static_cast<std::size_t>(layout.n_x), 0);
    for (const model::StateBlock& block : layout.x) {
      CHECK(block.body >= model::ContactPair::kEndEffector);
      for (int i = 0; i < block.size; ++i) ++owners[static_cast<std::size_t>(block.start + i)];
    }
    CHECK(owners == std::vector<int>(owners.size(), 1));
    CHECK(layout.n_e % 2 == 0);
  }
}

TEST_CASE("planning models: the state shows the end effector where the layout says") {
  support::Random random(3);
  for (const auto& model : all_models()) {
    const model::Layout& layout = model->layout();
    const scene::Scene scene = some_scene(random);
    VectorXd x = VectorXd::Constant(layout.n_x, -99.0);
    model->state(scene, x);
    CHECK(x.segment<3>(layout.p_WE) == scene.effector.p_WE);
    CHECK(x.segment<3>(layout.v_WE) == scene.effector.v_WE);
    CHECK((x.array() != -99.0).all());
  }
}

TEST_CASE("planning models: the contacts are those that are asked for, in their order") {
  support::Random random(4);
  for (const auto& model : all_models()) {
    const model::Layout& layout = model->layout();
    const scene::Scene scene = some_scene(random);
    const model::ContactSystem all = model->contact_system(scene, model::all_contacts(layout));
    CHECK(all.n_v() == layout.n_v);
    CHECK(all.n_u() == layout.n_u);
    CHECK(all.n_c() == layout.n_c());
    CHECK(all.n_e() == layout.n_e);
    for (int i = 0; i < layout.n_c(); ++i) {
      const model::ContactSystem one = model->contact_system(scene, {i});
      CHECK(one.phi[0] == all.phi[i]);
      CHECK(one.J_n.row(0) == all.J_n.row(i));
    }
  }
}

TEST_CASE("planning models: the force on the end effector is what accelerates it") {
  support::Random random(5);
  for (const auto& model : all_models()) {
    const model::Layout& layout = model->layout();
    const model::ContactSystem system =
        model->contact_system(some_scene(random), model::all_contacts(layout));
    const double dt = 0.01;
    const lcs::Lcs lcs = model::stewart_trinkle(system, dt);
    VectorXd lambda = random.vector(static_cast<int>(lcs.F.rows())).cwiseAbs();
    // D λ moves the end effector by its inverse mass, which u shows: B has the same
    const Vector3d by_contacts = (lcs.D * lambda).segment<3>(layout.v_WE);
    const Eigen::Matrix3d by_u = lcs.B.block<3, 3>(layout.v_WE, 0);
    const Vector3d force = model::force_on_end_effector(layout, system, lambda);
    CHECK((by_u * force - by_contacts).norm() < 1e-9 * by_contacts.norm());
  }
}

TEST_CASE("planning models: a kind that is not there is refused with those that are") {
  try {
    (void)model::model_kind("pushed_sphere");
    FAIL("accepted");
  } catch (const std::invalid_argument& e) {
    const std::string said = e.what();
    for (const model::ModelKind& kind : model::model_kinds())
      CHECK(said.find(kind.name) != std::string::npos);
    CHECK(said.find("pushed_sphere") != std::string::npos);
  }
  CHECK_THROWS_WITH(model::ModelValues()["ball_mass_kg"], Catch::Contains("ball_mass_kg"));
}
