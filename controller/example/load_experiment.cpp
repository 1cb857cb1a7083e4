#include "controller/example/load_experiment.hpp"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "controller/c3/load_settings.hpp"
#include "controller/lcs/riccati.hpp"
#include "controller/mjcf/mechanism.hpp"
#include "controller/model/cart_pole.hpp"
#include "controller/model/mechanism_model.hpp"

namespace c3rt::example {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr config::Range kWeight{0.0, 1e12};
constexpr int kMostContacts = 64;
constexpr config::Range kState{-1e6, 1e6};

/// Of an MJCF file, and which contacts it has.
void load_mechanism(config::Section& section, const std::string& key, model::ModelValues& values) {
  std::vector<model::Between> contacts;
  for (config::Section& each : section.list("contacts", 1, kMostContacts)) {
    const std::vector<std::string> between = each.texts("between", 2);
    contacts.push_back({between[0], between[1]});
    if (each.has("closest")) contacts.back().closest = each.integer("closest", {0, kMostContacts});
    if (each.has("friction")) contacts.back().friction = each.number("friction", {0, 10});
  }
  try {
    values.set_mechanism(mjcf::read_mechanism(section.file(key)).mechanism, std::move(contacts));
  } catch (const mjcf::Error& error) {
    section.fail(key, "a mechanism that can be planned with", error.what());
  }
}

Model load_model(const model::SystemKind& kind, config::Section section) {
  model::ModelValues values;
  for (const model::ModelKey& key : kind.keys) {
    if (key.names_mechanism) {
      load_mechanism(section, key.name, values);
      continue;
    }
    values.set(key.name, key.choices.empty()
                             ? section.number(key.name, {key.min, key.max})
                             : static_cast<double>(section.choice(key.name, key.choices)));
  }
  try {
    return kind.make(values);
  } catch (const std::invalid_argument& error) {
    section.fail("contacts", "contacts that the model can have", error.what());
  }
}

/// {NAME: …} on the diagonal, one for each entry of x or u.
MatrixXd load_named(config::Section section, const std::vector<model::Quantity>& quantities) {
  VectorXd weights(static_cast<Eigen::Index>(quantities.size()));
  for (std::size_t i = 0; i < quantities.size(); ++i)
    weights[static_cast<Eigen::Index>(i)] = section.number(quantities[i].name, kWeight);
  return weights.asDiagonal();
}

/// {x: …, lambda: …, u: …} on the diagonal of a z.
MatrixXd load_z_weight(config::Section section, const c3::Sizes& s) {
  // no comma initialiser: it must not be left by a ConfigError
  VectorXd weight(s.n_z());
  s.x(weight).setConstant(section.number("x", kWeight));
  s.lambda(weight).setConstant(section.number("lambda", kWeight));
  s.u(weight).setConstant(section.number("u", kWeight));
  return weight.asDiagonal();
}

void load_weights(config::Section section, const c3::Sizes& s, Experiment& e) {
  c3::Costs& costs = e.costs;
  costs.Q = load_named(section.section("Q"), e.model->layout().x);
  costs.R = load_named(section.section("R"), e.model->layout().u);
  const bool riccati = section.choice<bool>("Q_N", {{"riccati", true}, {"Q", false}});
  if (riccati) {
    const lcs::Lcs lcs = planning_system(e, e.x0);
    try {
      costs.Q_N = lcs::riccati(lcs.A, lcs.B, costs.Q[0], costs.R[0]);
    } catch (const std::exception& error) {
      section.fail("Q_N", "weights with a stabilising solution, or Q", error.what());
    }
  } else {
    costs.Q_N = costs.Q[0];
  }
  const c3::ProjectionKind projection = e.c3.projection;
  const c3::ProjectionType& type = c3::projection_type(projection);
  const std::string chosen = std::string("projection ") + type.key;
  if (section.given("G", type.needs_G, chosen)) costs.G = load_z_weight(section.section("G"), s);
  if (section.given("U", type.needs_U, chosen)) costs.U = load_z_weight(section.section("U"), s);
  for (const auto other : c3::kProjectionTypes) {
    const std::vector<c3::ProjectionWeight>& weights = other().weights;
    if (weights.empty() || !section.given(other().key, &other() == &type, chosen)) continue;
    config::Section own = section.section(other().key);
    for (const c3::ProjectionWeight& weight : weights) {
      if (weight.shape == c3::ProjectionWeight::Shape::kOfContacts && !own.has(weight.key))
        continue;
      weight.fill(costs, s,
                  own.number(weight.key, {weight.minimum, std::min(weight.maximum, kWeight.max)}));
    }
  }
}

Experiment load(config::Section root, const model::SystemKind& kind) {
  Experiment e{};
  e.model = load_model(kind, root.section("model"));
  config::Section plant = root.section("plant");
  // one model for both unless the plant is given its own
  e.plant = plant.has("model") ? load_model(kind, plant.section("model")) : e.model;
  e.mujoco_plant = plant.choice<bool>("kind", {{"lcs", false}, {"mujoco", true}});
  if (e.mujoco_plant && dynamic_cast<const model::CartPole*>(e.plant.get()) == nullptr &&
      dynamic_cast<const model::MechanismModel*>(e.plant.get()) == nullptr) {
    plant.fail("kind", "lcs: only cart-pole and mechanism have a MuJoCo plant", "\"mujoco\"");
  }
  e.simulation_step = plant.number("step_s", {1e-5, 1});
  e.noise = plant.number("noise_sigma", {0, 100});
  config::Section disturbance = plant.section("disturbance");
  e.disturbance = {disturbance.number("start_s", {0, 1e6}),
                   disturbance.number("duration_s", {0, 1e6}), disturbance.number("min", kState),
                   disturbance.number("max", kState)};

  config::Section control = root.section("control");
  e.N = control.integer("horizon", {1, 1000});
  e.planning_step = control.number("planning_step_s", {1e-4, 10});
  e.control_period = control.number("period_s", {1e-4, 10});
  e.duration = control.number("duration_s", {1e-3, 1e5});

  const int n_x = e.model->layout().n_x();
  config::Section start = root.section("start");
  e.x0 = start.numbers("x0", n_x, kState);
  e.x0_spread_min = start.numbers("spread_min", n_x, kState);
  e.x0_spread_max = start.numbers("spread_max", n_x, kState);
  e.trials = start.integer("trials", {1, 100000});
  config::Section goal = root.section("goal");
  e.x_desired = goal.numbers("x_desired", n_x, kState);
  e.success_min = goal.limits("success_min", n_x);
  e.success_max = goal.limits("success_max", n_x);

  config::Section c3 = root.section("c3");
  e.c3 = c3::load_settings(c3);
  e.c3.delta_starts_at_x0 = c3.boolean("delta_starts_at_x0");
  e.c3.fix_lambda_0 = c3.boolean("fix_lambda_0");
  e.start = c3.choice<StartPolicy>("start", {{"fresh", StartPolicy::kFresh},
                                             {"carried_forces", StartPolicy::kCarriedForces},
                                             {"shifted", StartPolicy::kShifted}});
  const bool carries = e.start == StartPolicy::kCarriedForces;
  if (c3.given("start_reset_period_s", carries, "start carried_forces"))
    e.start_reset_period = c3.number("start_reset_period_s", {0, 1e6});

  const c3::Sizes s = sizes(e);
  load_weights(root.section("weights"), s, e);
  config::Section constraints = root.section("constraints");
  e.constraints.x_min = constraints.limits("x_min", s.n_x);
  e.constraints.x_max = constraints.limits("x_max", s.n_x);
  e.constraints.u_min = constraints.limits("u_min", s.n_u);
  e.constraints.u_max = constraints.limits("u_max", s.n_u);
  if (e.c3.qp == c3::QpBackend::kDirect && any(e.constraints)) {
    c3.fail("qp", "interior_point or osqp, which know constraints", "\"direct\"");
  }
  try {
    check(e.costs, s, e.c3.projection);
    check(e.constraints, s);
  } catch (const std::invalid_argument& error) {
    root.fail("weights", "weights and constraints that C3 can use", error.what());
  }
  return e;
}

}  // namespace

Experiment load_experiment(config::Section root) {
  std::vector<std::string> names;
  for (const model::SystemKind& kind : model::system_kinds()) names.push_back(kind.name);
  const auto chosen = static_cast<std::size_t>(root.choice("example", names));
  return load(root, model::system_kinds()[chosen]);
}

}  // namespace c3rt::example
