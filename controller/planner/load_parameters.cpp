#include "controller/planner/load_parameters.hpp"

#include <algorithm>
#include <cmath>

#include "controller/base/words.hpp"
#include "controller/c3/load_settings.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/planner/c3_controller.hpp"
#include "controller/planner/strategy/registry.hpp"

namespace c3rt::planner {
namespace {

constexpr config::Range kWeight{0.0, kLargestWeight};
constexpr config::Range kPositiveWeight{1e-12, kLargestWeight};

/// One weight for all rows of η, or `KEY_distance` and `KEY_slip` beside that of the cone.
PhaseWeights::Rows load_rows(config::Section& section, const std::string& key,
                             config::Range allowed) {
  const double cone = section.number(key, allowed);
  return {cone, section.number(key + "_distance", allowed, cone),
          section.number(key + "_slip", allowed, cone)};
}

/// The weights that one projection alone has; those of x and u are U's.
std::map<std::string, PhaseWeights::Rows> load_own(config::Section& section,
                                                   const c3::ProjectionType& type) {
  using Shape = c3::ProjectionWeight::Shape;
  std::map<std::string, PhaseWeights::Rows> own;
  for (const c3::ProjectionWeight& weight : type.weights) {
    const config::Range allowed{weight.minimum, std::min(weight.maximum, kWeight.max)};
    switch (weight.shape) {
      case Shape::kOfStates:
      case Shape::kOfInputs:
      case Shape::kOfContacts:
        break;
      case Shape::kOfGaps:
        own[weight.key] = load_rows(section, weight.key, allowed);
        break;
      case Shape::kOfForces:
        if (weight.of_consensus && !section.has(weight.key)) break;  // as G has them
        [[fallthrough]];
      case Shape::kNumber:
        const double value = section.number(weight.key, allowed);
        own[weight.key] = {value, value, value};
        break;
    }
  }
  return own;
}

/// Those that count contact by contact: of the kinds that are named, and 1 of the others.
std::map<std::string, std::map<std::string, double>> load_of_contacts(
    config::Section& section, const c3::ProjectionType& type, const model::Layout& layout) {
  std::map<std::string, std::map<std::string, double>> all;
  for (const c3::ProjectionWeight& weight : type.weights) {
    if (weight.shape != c3::ProjectionWeight::Shape::kOfContacts || !section.has(weight.key))
      continue;
    config::Section of_contacts = section.section(weight.key);
    for (const std::string& contact : contact_weights(layout))
      all[weight.key][contact] =
          of_contacts.number(contact, {weight.minimum, kWeight.max}, weight.minimum);
  }
  return all;
}

bool weighs_x(const c3::ProjectionType& type) {
  return std::any_of(type.weights.begin(), type.weights.end(), [](const auto& weight) {
    return weight.shape == c3::ProjectionWeight::Shape::kOfStates;
  });
}

PhaseWeights load_weights(config::Section section, const model::Layout& layout,
                          c3::ProjectionKind projection) {
  PhaseWeights weights{};
  config::Section Q = section.section("Q");
  for (const std::string& name : layout.weights()) {
    const int bodies = static_cast<int>(layout.bodies(name).size());
    const Eigen::VectorXd of_bodies = Q.one_or_each(name, bodies, kWeight);
    weights.Q[name].assign(of_bodies.data(), of_bodies.data() + of_bodies.size());
  }
  weights.R = section.number("R", kPositiveWeight);
  config::Section G = section.section("G");
  weights.G_x = G.number("x", kPositiveWeight);
  weights.G_u = G.number("u", kPositiveWeight);
  for (const std::string& name : lambda_weights(layout))
    weights.G_lambda[name] = G.number(name, kPositiveWeight);
  const c3::ProjectionType& type = c3::projection_type(projection);
  const std::string chosen = std::string("projection ") + type.key;
  if (section.given("U", type.needs_U || weighs_x(type), chosen)) {
    config::Section U = section.section("U");
    weights.U_x = U.number("x", kPositiveWeight);
    weights.U_lambda = U.number("lambda", kPositiveWeight);
    weights.U_u = U.number("u", kPositiveWeight);
  }
  for (const auto other : c3::kProjectionTypes) {
    if (other().weights.empty() || !section.given(other().key, &other() == &type, chosen)) continue;
    config::Section own = section.section(other().key);
    weights.of_projections[other().key] = load_own(own, other());
    weights.of_contacts[other().key] = load_of_contacts(own, other(), layout);
  }
  return weights;
}

/// The objects of MJCF files, one for all bodies or one for each.
std::vector<scene::Object> load_objects(config::Section& section, const std::string& key,
                                        int bodies) {
  std::vector<std::string> files = section.files(key, 1, bodies);
  if (files.size() == 1) files.resize(static_cast<std::size_t>(bodies), files.front());
  if (static_cast<int>(files.size()) != bodies) {
    section.fail(key, "one file, or one for each of " + std::to_string(bodies) + " objects",
                 std::to_string(files.size()));
  }
  std::vector<scene::Object> objects;
  try {
    for (const std::string& file : files) objects.push_back(mjcf::read_object(file).object);
  } catch (const mjcf::Error& e) {
    section.fail(key, "objects that can be planned with", e.what());
  }
  return objects;
}

void load_value(config::Section& section, const model::ModelKey& key, ModelParameters& parameters) {
  if (key.names_objects) {
    parameters.values.set_objects(load_objects(section, key.name, parameters.bodies));
  } else if (key.missing && !section.has(key.name)) {
    parameters.values.set(key.name, *key.missing);
  } else if (!key.choices.empty()) {
    parameters.values.set(key.name, section.choice(key.name, key.choices));
  } else {
    parameters.values.set(key.name, section.number(key.name, {key.min, key.max}));
  }
}

/// The kind of the model, its numbers, and {NAME OF A PAIR: true, …}: the contacts to plan with.
ModelParameters load_model(config::Section& section, int bodies) {
  ModelParameters parameters{};
  parameters.bodies = bodies;
  parameters.kind = model::default_model_kind(bodies).name;
  if (section.has("kind")) {
    parameters.kind = section.name("kind");
    std::string known;
    bool found = false;
    for (const model::ModelKind& kind : model::model_kinds()) {
      found |= kind.name == parameters.kind;
      known += (known.empty() ? "" : ", ") + kind.name;
    }
    if (!found) section.fail("kind", "one of " + known, "\"" + parameters.kind + "\"");
  }
  const model::ModelKind& kind = model::model_kind(parameters.kind);
  if (bodies < kind.min_bodies || bodies > kind.max_bodies) {
    section.fail("kind",
                 "a model of " + std::to_string(bodies) + (bodies == 1 ? " body" : " bodies"),
                 kind.name + ", for " + std::to_string(kind.min_bodies) + " to " +
                     std::to_string(kind.max_bodies));
  }
  for (const model::ModelKey& key : kind.keys) load_value(section, key, parameters);
  parameters.contact_model = section.choice<model::ContactModel>(
      "contact_model", {{"stewart_trinkle", model::ContactModel::kStewartTrinkle},
                        {"anitescu", model::ContactModel::kAnitescu}});
  config::Section pairs = section.section("contacts");
  std::set<std::string> asked;
  const std::unique_ptr<model::PlanningModel> made = make_model(parameters);
  for (const model::ModelContact& contact : made->layout().contacts) {
    if (!asked.insert(contact.pair).second) continue;
    if (pairs.boolean(contact.pair)) parameters.pairs.insert(contact.pair);
  }
  if (parameters.pairs.empty()) section.fail("contacts", "at least one pair that is true", "none");
  return parameters;
}

/// How much heavier and larger the model's body is than the one that weights, lengths and forces of
/// the section were tuned with.
struct Ratio {
  double mass = 1.0, size = 1.0;
};

// What the settings were seen to hold (docs/experiments.md, "Other balls").
constexpr double kSmallest = 0.63, kLargest = 1.7, kLightest = 0.25, kHeaviest = 4.5;

// The arm is pressed down with this on a body over which the way is half as long [N].
constexpr double kLandingPress = 3.5;

/// @throws ConfigError where the model's value is not within these times the tuned one
double carried(const config::Section& tuned, const char* key, const ModelParameters& model,
               const std::string& model_key, double tuned_value, double least, double most) {
  const double ratio = model.values[model_key] / tuned_value;
  if (ratio >= least && ratio <= most) return ratio;
  tuned.fail(
      key,
      base::words(
          "that of a body that model.%s is %g to %g times of, which is what the settings can "
          "hold (others need settings and a tuned_for of their own)",
          model_key.c_str(), least, most),
      base::words("%g, of which %g is %.3g times", tuned_value, model.values[model_key], ratio));
}

Ratio load_ratio(config::Section& section, const ModelParameters& model) {
  if (!section.has("tuned_for")) return {};
  config::Section tuned = section.section("tuned_for");
  const double mass = tuned.number("mass_kg", {1e-3, 100}),
               size = tuned.number("radius_m", {1e-3, 1});
  const model::ModelKind& kind = model::model_kind(model.kind);
  if (kind.mass_key.empty())
    section.fail("tuned_for", "none beside a model of kind " + kind.name, "one");
  const Ratio ratio{carried(tuned, "mass_kg", model, kind.mass_key, mass, kLightest, kHeaviest),
                    carried(tuned, "radius_m", model, kind.size_key, size, kSmallest, kLargest)};
  tuned.finish();
  return ratio;
}

/// Carries what was tuned with one body over to the model's. Forces grow with its mass, heights are
/// those above its top. The end effector, which stays as it is, rolls over it on a circle of both
/// radii: ways beside the top grow with that, so that they end at the same angle. From behind a
/// larger body, which has room, it comes by as much more as that is larger.
void carry_over(const Ratio& ratio, Parameters& parameters) {
  const model::ModelKind& kind = model::model_kind(parameters.model.kind);
  const double mass = parameters.model.values[kind.mass_key] / ratio.mass;
  const double radius = parameters.model.values[kind.size_key], tuned = radius / ratio.size;
  const double larger = radius - tuned, effector = parameters.geometry.end_effector_radius;
  const double way = (radius + effector) / (tuned + effector);
  // What is over sooner on a smaller body gets less time: Phase I by the way at the same speed, a
  // planning step by the time in which gravity moves a body along it. A larger one has room for the
  // same times. Phase II takes the time that the arm needs.
  const double shorter = std::min(1.0, way), step = std::sqrt(shorter);
  parameters.dt *= step;
  parameters.model.values.set(kind.mass_key, mass);
  parameters.model.force_unit = ratio.mass;
  parameters.model.force_scale_ratio = (ratio.size / step) * (ratio.size / step);
  HeuristicParameters& heuristic = parameters.heuristic;
  heuristic.roll_duration *= shorter;
  heuristic.roll_reach *= way;
  heuristic.return_back *= std::max(way, ratio.size);
  heuristic.return_heights.array() += 2.0 * larger;
  // The arm rebounds where it lands, for a time that is a larger part of a shorter way, and over a
  // gap there is no grip. What presses it down makes the time shorter by as much.
  heuristic.roll_press = heuristic.roll_press * ratio.mass + kLandingPress * (1.0 / shorter - 1.0);
  parameters.approach.safe_height += 2.0 * larger;
  parameters.approach.start_height += larger;
}

PhaseWeights load_phase(config::Section& weights, const char* phase, const Parameters& parameters) {
  const std::unique_ptr<model::PlanningModel> planned = make_model(parameters.model);
  return load_weights(weights.section(phase), planned->layout(), parameters.c3.projection);
}

HeuristicParameters load_heuristic(config::Section heuristic, int bodies) {
  HeuristicParameters parameters{};
  parameters.roll_duration = heuristic.number("roll_duration_s", {0.01, 60});
  parameters.return_duration = heuristic.number("return_duration_s", {0.01, 60});
  parameters.roll_clearance = heuristic.number("roll_clearance_m", {-0.05, 0.2});
  parameters.return_back = heuristic.number("return_back_m", {0, 0.2});
  parameters.return_heights = heuristic.numbers("return_heights_m", 3, {0, 0.5});
  const HeuristicParameters none{};
  parameters.roll_press = heuristic.number("roll_press_n", {0, 20}, none.roll_press);
  parameters.roll_reach = heuristic.number("roll_reach_m", {0.01, 1}, none.roll_reach);
  parameters.return_gap = heuristic.number("return_gap_m", {1e-3, 1}, none.return_gap);
  parameters.return_lead = heuristic.number("return_lead_s", {0, 1}, none.return_lead);
  if (heuristic.has("return_follows"))
    parameters.return_follows = heuristic.boolean("return_follows");
  parameters.target_reach = heuristic.number("target_reach_m", {1e-3, 1}, none.target_reach);
  if (bodies > 1) {
    parameters.look_ahead = heuristic.number("look_ahead_s", {0, 10});
    parameters.beside_weight = heuristic.number("beside_weight", {0, 100});
    parameters.change_margin = heuristic.number("change_margin_m", {0, 1});
    parameters.room_ahead = heuristic.number("room_ahead_m", {0, 1});
  }
  return parameters;
}

SamplingParameters load_sampling(config::Section sampling, double effector_radius) {
  constexpr double kAboveTable = 2e-3;  // as the arm is not exact, and would rub on the table [m]
  SamplingParameters parameters{};
  parameters.height = sampling.number("height_m", {effector_radius + kAboveTable, 0.5});
  parameters.clearance = sampling.number("clearance_m", {1e-3, 0.1});
  parameters.look_ahead = sampling.number("look_ahead_m", {1e-3, 1});
  parameters.look_ahead_angle = sampling.number("look_ahead_rad", {0.01, 3});
  parameters.reach_min = sampling.numbers("reach_min_m", 2, {-2, 2});
  parameters.reach_max = sampling.numbers("reach_max_m", 2, {-2, 2});
  if ((parameters.reach_min.array() >= parameters.reach_max.array()).any())
    sampling.fail("reach_max_m", "every entry above that of reach_min_m", "one that is not");
  parameters.reach_radius = sampling.number("reach_radius_m", {0.1, 2});
  parameters.samples = sampling.integer("samples", {1, 64});
  parameters.samples_to_choose = sampling.integer("samples_to_choose", {1, 64});
  parameters.least_drawn = sampling.integer("least_drawn", {1, 1000});
  parameters.better = sampling.number("better", {1, 100});
  parameters.margin = sampling.number("margin", {0, 1});
  parameters.retarget = sampling.number("retarget", {0, 1});
  parameters.least_time = sampling.number("least_time_s", {0, 60});
  parameters.headway = sampling.number("headway", {0, 1});
  parameters.headway_time = sampling.number("headway_time_s", {0.01, 60});
  parameters.valid_moved = sampling.number("valid_moved_m", {0, 1});
  parameters.valid_turned = sampling.number("valid_turned_rad", {0, 4});
  parameters.speed = sampling.number("speed_m_per_s", {0.01, 1});
  parameters.acceleration = sampling.number("acceleration_m_per_s2", {0.1, 20});
  parameters.clear = sampling.number("clear_m", {0, 0.1});
  if (sampling.has("threads")) parameters.threads = sampling.integer("threads", {1, 64});
  if (sampling.has("way"))
    parameters.over = sampling.choice<bool>("way", {{"over", true}, {"beside", false}});
  config::Section servo = sampling.section("servo");
  parameters.servo.stiffness = servo.number("stiffness_n_per_m", {0, 1e5});
  parameters.servo.damping = servo.number("damping_n_s_per_m", {0, 1e4});
  return parameters;
}

/// By name: of a strategy that is not chosen the sections may be left out.
void load_strategy(config::Section& section, Parameters& parameters) {
  if (section.has("strategy")) {
    std::vector<std::string> names;
    for (const StrategyKind& kind : strategy_kinds()) names.push_back(kind.name);
    parameters.strategy = names[static_cast<std::size_t>(section.choice("strategy", names))];
  }
  const bool heuristic = parameters.strategy == "time_heuristic";
  const scene::Scene world = make_model(parameters.model)->layout().world;
  if (heuristic && world.body(0).shape.kind != scene::ShapeKind::kSphere)
    section.fail(
        "strategy",
        "one that knows other bodies than spheres, as a " + parameters.model.kind + " is none",
        "time_heuristic");
  const std::string why = "strategy " + parameters.strategy;
  const bool sampling = parameters.strategy == "sampling";
  if (section.given("sampling", sampling, why))
    parameters.sampling = load_sampling(section.section("sampling"), world.effector.radius);
  if (section.given("weights", heuristic || sampling, why)) {
    config::Section weights = section.section("weights");
    if (weights.given("roll", heuristic, why)) {
      parameters.roll = load_phase(weights, "roll", parameters);
      parameters.back = load_phase(weights, "return", parameters);
    }
    if (weights.given("push", sampling, why))
      parameters.sampling.weights = load_phase(weights, "push", parameters);
    parameters.weights_adjustable_by = weights.number("adjustable_by", {1, 1e6}, 1.0);
  }
  if (section.given("heuristic", heuristic, "strategy time_heuristic"))
    parameters.heuristic = load_heuristic(section.section("heuristic"), parameters.model.bodies);
}

}  // namespace

Parameters load_parameters(config::Section section, const task::Task& task, int bodies) {
  Parameters parameters{};
  parameters.task = task;
  parameters.rate = section.number("rate_hz", {1, 1000});
  parameters.publish_delay = section.number("publish_delay_s", {0, 0.2});
  parameters.valid_for = section.number("valid_for_s", {0.001, 5});
  parameters.estimate_timeout = section.number("estimate_timeout_s", {0.01, 10});
  parameters.deadline_fraction = section.number("deadline_fraction", {0.05, 1});
  parameters.N = section.integer("horizon", {1, 10});
  parameters.dt = section.number("step_s", {1e-3, 1});
  parameters.delta_t_c_source = section.choice<DeltaTcSource>(
      "delta_t_c", {{"period", DeltaTcSource::kPeriod}, {"solve_time", DeltaTcSource::kSolveTime}});
  if (section.has("delta_t_c_s"))
    parameters.delta_t_c = section.number("delta_t_c_s", {1e-3, parameters.dt});
  parameters.speed_limit = section.number("speed_limit_m_per_s", {0.01, 10});
  parameters.predict_objects = section.boolean("predict_objects");
  parameters.separate_overlap = section.boolean("separate_overlap");
  if (section.has("table_below_object"))
    parameters.table_below_object = section.boolean("table_below_object");
  parameters.tilt = section.number("tool_tilt_rad", {0, 0.6});

  if (section.has("scale_forces")) parameters.scale_forces = section.boolean("scale_forces");

  config::Section model = section.section("model");
  parameters.model = load_model(model, bodies);
  const scene::Scene world = make_model(parameters.model)->layout().world;
  parameters.geometry = {world.effector.radius, world.table_height};

  parameters.c3 = c3::load_settings(section.section("c3"));
  parameters.c3.delta_starts_at_x0 = true;  // step 2 of Algorithm 3

  load_strategy(section, parameters);

  config::Section approach = section.section("approach");
  parameters.approach.speed = approach.number("speed_m_per_s", {0.001, 1});
  parameters.approach.safe_height = approach.number("safe_height_m", {0.05, 0.5});
  parameters.approach.start_height = approach.number("start_height_above_object_m", {0.01, 0.3});
  parameters.approach.tolerance = approach.number("tolerance_m", {1e-4, 0.05});
  parameters.approach.leash = approach.number("leash_m", {1e-3, 1});
  parameters.approach.reach_min = approach.numbers("reach_min_m", 2, {-2, 2});
  parameters.approach.reach_max = approach.numbers("reach_max_m", 2, {-2, 2});
  if ((parameters.approach.reach_min.array() >= parameters.approach.reach_max.array()).any())
    approach.fail("reach_max_m", "every entry above that of reach_min_m", "one that is not");
  parameters.approach.settle_time = approach.number("settle_time_s", {0, 10});
  const Ratio ratio = load_ratio(section, parameters.model);
  if (ratio.mass != 1.0 || ratio.size != 1.0) carry_over(ratio, parameters);
  section.finish();
  return parameters;
}

}  // namespace c3rt::planner
