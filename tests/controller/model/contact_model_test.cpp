#include "controller/model/contact_model.hpp"

#include <catch2/catch.hpp>

#include "controller/model/ball_model.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using model::ContactModel;
using model::LambdaLayout;
using model::Row;

namespace {

// end effector above a ball on the table
model::ContactSystem system_with(const std::vector<model::BallContact>& contacts) {
  scene::Scene scene;
  scene.effector.p_WE = {0.5, 0.0, 0.09};
  scene.body(0).p_WB = {0.51, 0.01, 0.0315};
  return model::ball_contact_system({0.01, 0.0195, 0.132, 0.0315, 0.0, 0.8, 0.6}, scene, contacts);
}

}  // namespace

TEST_CASE("contact model: lambda's layout counts what the LCS has, with and without friction") {
  using C = model::BallContact;
  for (const std::vector<C>& contacts :
       {std::vector<C>{C::kTable}, std::vector<C>{C::kEndEffector, C::kTable}}) {
    const model::ContactSystem system = system_with(contacts);
    model::ContactSystem smooth = system;
    smooth.J_t.resize(0, system.n_v());
    for (const ContactModel kind : {ContactModel::kStewartTrinkle, ContactModel::kAnitescu}) {
      for (const model::ContactSystem* of :
           {&system, const_cast<const model::ContactSystem*>(&smooth)}) {
        const LambdaLayout layout(kind, static_cast<int>(of->n_c()), static_cast<int>(of->n_e()));
        CHECK(layout.size() == model::to_lcs(kind, *of, 0.01).F.rows());
      }
    }
  }
}

TEST_CASE("contact model: each row of Stewart and Trinkle's LCS is what the layout says it is") {
  const model::ContactSystem system =
      system_with({model::BallContact::kEndEffector, model::BallContact::kTable});
  const lcs::Lcs lcs = model::to_lcs(ContactModel::kStewartTrinkle, system, 0.01);
  const LambdaLayout layout(ContactModel::kStewartTrinkle, 2, 4);
  for (int contact = 0; contact < 2; ++contact) {
    // the cone: μ λ_n less the sum of the edges; its row moves with forces alone
    const int gamma = layout.gamma(contact), normal = layout.normal(contact);
    CHECK(layout.row(gamma) == Row::kCone);
    CHECK(lcs.E.row(gamma).isZero());
    CHECK(lcs.F(gamma, normal) == system.mu[contact]);
    // the distance: a force along the normal opens it
    CHECK(layout.row(normal) == Row::kDistance);
    CHECK(lcs.F(normal, normal) > 0.0);
    // the slip: each edge has the contact's γ in its row and itself in the cone's
    for (int edge = 0; edge < layout.edge_count(); ++edge) {
      const int at = layout.edges(contact) + edge;
      CHECK(layout.row(at) == Row::kSlip);
      CHECK(lcs.F(at, gamma) == 1.0);
      CHECK(lcs.F(gamma, at) == -1.0);
    }
  }
  CHECK(layout.edges(1) + layout.edge_count() == layout.size());
}

TEST_CASE("contact model: what a contact pushes with is the same force in either model") {
  // the end effector alone, pressed on the ball: without slip Anitescu's impulses are the forces
  const model::ContactSystem system = system_with({model::BallContact::kEndEffector});
  const double dt = 0.01;
  const lcs::Lcs exact = model::to_lcs(ContactModel::kStewartTrinkle, system, dt);
  const lcs::Lcs convex = model::to_lcs(ContactModel::kAnitescu, system, dt);
  const LambdaLayout of_exact(ContactModel::kStewartTrinkle, 1, 4),
      of_convex(ContactModel::kAnitescu, 1, 4);
  // an impulse along all four edges of the cone is one along the normal
  const Eigen::VectorXd by_force = exact.D.col(of_exact.normal(0));
  Eigen::VectorXd by_impulse = Eigen::VectorXd::Zero(by_force.size());
  for (int edge = 0; edge < 4; ++edge) by_impulse += 0.25 * convex.D.col(of_convex.edges(0) + edge);
  CHECK((by_force - by_impulse / model::newtons(ContactModel::kAnitescu, 1.0, dt)).norm() <
        1e-12 * by_force.norm());
  CHECK(model::newtons(ContactModel::kStewartTrinkle, 3.0, dt) == 3.0);
}
