#include "controller/planner/load_parameters.hpp"

#include "controller/c3/load_settings.hpp"

namespace c3rt::planner {
namespace {

constexpr config::Range kWeight{0.0, 1e12};
constexpr config::Range kPositiveWeight{1e-12, 1e12};

/// One weight for all rows of η, or `KEY_distance` and `KEY_slip` beside that of the cone.
PhaseWeights::Gaps load_gaps(config::Section& plus, const std::string& key) {
  const double cone = plus.number(key, kPositiveWeight);
  return {cone, plus.number(key + "_distance", kPositiveWeight, cone),
          plus.number(key + "_slip", kPositiveWeight, cone)};
}

PhaseWeights load_weights(config::Section section, int balls, c3::ProjectionKind projection) {
  PhaseWeights weights{};
  config::Section Q = section.section("Q");
  weights.Q_end_effector = Q.number("end_effector", kWeight);
  weights.Q_end_effector_velocity = Q.number("end_effector_velocity", kWeight);
  const Eigen::VectorXd Q_ball_xy = Q.one_or_each("ball_xy", balls, kWeight);
  weights.Q_ball_xy.assign(Q_ball_xy.data(), Q_ball_xy.data() + Q_ball_xy.size());
  if (balls == 1) weights.Q_ball_z = Q.number("ball_z", kWeight);
  weights.Q_ball_velocity = Q.number("ball_velocity", kWeight);
  weights.R = section.number("R", kPositiveWeight);
  config::Section G = section.section("G");
  weights.G_x = G.number("x", kPositiveWeight);
  weights.G_u = G.number("u", kPositiveWeight);
  weights.G_gamma = G.number("gamma", kPositiveWeight);
  weights.G_end_effector_normal = G.number("end_effector_normal", kPositiveWeight);
  weights.G_end_effector_tangential = G.number("end_effector_tangential", kPositiveWeight);
  if (balls == 1) {
    weights.G_table_normal = G.number("table_normal", kPositiveWeight);
    weights.G_table_tangential = G.number("table_tangential", kPositiveWeight);
  } else {
    weights.G_balls_normal = G.number("balls_normal", kPositiveWeight);
    weights.G_balls_tangential = G.number("balls_tangential", kPositiveWeight);
  }
  const bool lcp = projection == c3::ProjectionKind::kLcp;
  const bool is_convex = projection == c3::ProjectionKind::kConvex;
  const bool is_plus = projection == c3::ProjectionKind::kPlus;
  if (section.given("U", !lcp && !is_plus, "a projection other than lcp and plus")) {
    config::Section U = section.section("U");
    weights.U_x = U.number("x", kPositiveWeight);
    weights.U_lambda = U.number("lambda", kPositiveWeight);
    weights.U_u = U.number("u", kPositiveWeight);
  }
  if (section.given("convex", is_convex, "projection convex")) {
    config::Section convex = section.section("convex");
    weights.convex_alpha = convex.number("alpha", {0, 1});
    weights.convex_epsilon = convex.number("epsilon", {0, 1});
  }
  if (section.given("plus", is_plus, "projection plus")) {
    config::Section plus = section.section("plus");
    if (plus.has("g_lambda")) weights.plus_g_lambda = plus.number("g_lambda", kPositiveWeight);
    weights.plus_u_lambda = plus.number("u_lambda", kPositiveWeight);
    weights.plus_g_eta = load_gaps(plus, "g_eta");
    weights.plus_u_eta = load_gaps(plus, "u_eta");
  }
  return weights;
}

/// {end_effector_ball: true, ball_table: true}: the contact pairs of the planning model; of several
/// balls {end_effector_ball: true, ball_ball: true}.
void load_contacts(config::Section& model, Parameters& parameters) {
  config::Section pairs = model.section("contacts");
  const bool end_effector = pairs.boolean("end_effector_ball");
  if (parameters.balls == 1) {
    if (end_effector) parameters.contacts.push_back(model::BallContact::kEndEffector);
    if (pairs.boolean("ball_table")) parameters.contacts.push_back(model::BallContact::kTable);
  } else {
    const bool balls = pairs.boolean("ball_ball");
    for (const model::ContactPair& pair : model::all_contact_pairs(parameters.balls)) {
      const bool with_end_effector = pair.first == model::ContactPair::kEndEffector;
      if (with_end_effector ? end_effector : balls) parameters.pairs.push_back(pair);
    }
  }
  if (parameters.contacts.empty() && parameters.pairs.empty())
    model.fail("contacts", "at least one pair that is true", "none");
}

DisturbanceParameters load_disturbance(config::Section section) {
  DisturbanceParameters disturbance{};
  disturbance.noise = section.number("noise_m", {1e-6, 0.1});
  disturbance.memory = section.number("memory_s", {0.01, 1e4});
  disturbance.limit = section.number("limit_m_per_s2", {1e-3, 10});
  disturbance.gap = section.number("gap_m", {0, 0.1});
  disturbance.settle = section.number("settle_s", {0, 1});
  return disturbance;
}

}  // namespace

Parameters load_parameters(config::Section section, const Task& task, int balls) {
  Parameters parameters{};
  parameters.task = task;
  parameters.balls = balls;
  parameters.rate = section.number("rate_hz", {1, 1000});
  parameters.publish_delay = section.number("publish_delay_s", {0, 0.2});
  parameters.valid_for = section.number("valid_for_s", {0.001, 5});
  parameters.estimate_timeout = section.number("estimate_timeout_s", {0.01, 10});
  parameters.deadline_fraction = section.number("deadline_fraction", {0.05, 1});
  parameters.N = section.integer("horizon", {1, 10});
  parameters.dt = section.number("step_s", {1e-3, 1});
  parameters.delta_t_c_source = section.choice<DeltaTcSource>(
      "delta_t_c", {{"period", DeltaTcSource::kPeriod}, {"solve_time", DeltaTcSource::kSolveTime}});
  parameters.speed_limit = section.number("speed_limit_m_per_s", {0.01, 10});
  parameters.predict_ball = section.boolean("predict_ball");
  parameters.separate_overlap = section.boolean("separate_overlap");
  if (section.has("table_below_ball"))
    parameters.table_below_ball = section.boolean("table_below_ball");
  parameters.tilt = section.number("tool_tilt_rad", {0, 0.6});
  if (balls == 1 && section.has("ball_disturbance"))
    parameters.disturbance = load_disturbance(section.section("ball_disturbance"));

  config::Section model = section.section("model");
  parameters.model.end_effector_mass = model.number("end_effector_mass_kg", {1e-4, 100});
  parameters.model.end_effector_radius = model.number("end_effector_radius_m", {1e-3, 1});
  parameters.model.ball_mass = model.number("ball_mass_kg", {1e-3, 100});
  parameters.model.ball_radius = model.number("ball_radius_m", {1e-3, 1});
  parameters.model.table_height = model.number("table_height_m", {-2, 2});
  parameters.model.friction_end_effector = model.number("friction_end_effector", {0, 10});
  if (balls == 1) {
    parameters.model.friction_table = model.number("friction_table", {0, 10});
  } else {
    parameters.friction_balls = model.number("friction_balls", {0, 10});
  }
  parameters.contact_model = model.choice<ContactModel>(
      "contact_model",
      {{"stewart_trinkle", ContactModel::kStewartTrinkle}, {"anitescu", ContactModel::kAnitescu}});
  load_contacts(model, parameters);

  parameters.c3 = c3::load_settings(section.section("c3"));
  parameters.c3.delta_starts_at_x0 = true;  // step 2 of Algorithm 3

  config::Section weights = section.section("weights");
  parameters.roll = load_weights(weights.section("roll"), balls, parameters.c3.projection);
  parameters.back = load_weights(weights.section("return"), balls, parameters.c3.projection);

  config::Section heuristic = section.section("heuristic");
  parameters.heuristic.roll_duration = heuristic.number("roll_duration_s", {0.01, 60});
  parameters.heuristic.return_duration = heuristic.number("return_duration_s", {0.01, 60});
  parameters.heuristic.roll_clearance = heuristic.number("roll_clearance_m", {-0.05, 0.2});
  parameters.heuristic.return_back = heuristic.number("return_back_m", {0, 0.2});
  parameters.heuristic.return_heights = heuristic.numbers("return_heights_m", 3, {0, 0.5});
  const HeuristicParameters none{};
  parameters.heuristic.roll_press = heuristic.number("roll_press_n", {0, 20}, none.roll_press);
  parameters.heuristic.roll_reach = heuristic.number("roll_reach_m", {0.01, 1}, none.roll_reach);
  parameters.heuristic.return_gap = heuristic.number("return_gap_m", {1e-3, 1}, none.return_gap);
  parameters.heuristic.return_lead = heuristic.number("return_lead_s", {0, 1}, none.return_lead);
  if (heuristic.has("return_follows"))
    parameters.heuristic.return_follows = heuristic.boolean("return_follows");
  parameters.heuristic.target_reach =
      heuristic.number("target_reach_m", {1e-3, 1}, none.target_reach);

  if (balls > 1) {
    parameters.heuristic.look_ahead = heuristic.number("look_ahead_s", {0, 10});
    parameters.heuristic.beside_weight = heuristic.number("beside_weight", {0, 100});
    parameters.heuristic.change_margin = heuristic.number("change_margin_m", {0, 1});
    parameters.heuristic.room_ahead = heuristic.number("room_ahead_m", {0, 1});
  }

  config::Section approach = section.section("approach");
  parameters.approach.speed = approach.number("speed_m_per_s", {0.001, 1});
  parameters.approach.safe_height = approach.number("safe_height_m", {0.05, 0.5});
  parameters.approach.start_height = approach.number("start_height_above_ball_m", {0.01, 0.3});
  parameters.approach.tolerance = approach.number("tolerance_m", {1e-4, 0.05});
  parameters.approach.leash = approach.number("leash_m", {1e-3, 1});
  parameters.approach.reach_min = approach.numbers("reach_min_m", 2, {-2, 2});
  parameters.approach.reach_max = approach.numbers("reach_max_m", 2, {-2, 2});
  if ((parameters.approach.reach_min.array() >= parameters.approach.reach_max.array()).any())
    approach.fail("reach_max_m", "every entry above that of reach_min_m", "one that is not");
  parameters.approach.settle_time = approach.number("settle_time_s", {0, 10});
  section.finish();
  return parameters;
}

}  // namespace c3rt::planner
