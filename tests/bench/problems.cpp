#include "tests/bench/problems.hpp"

#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "config/section.hpp"
#include "controller/example/closed_loop.hpp"
#include "controller/example/load_experiment.hpp"
#include "controller/model/ball_model.hpp"
#include "controller/model/balls_model.hpp"
#include "tests/support/rolling_ball.hpp"

namespace bench {
namespace {

using namespace c3rt;
using c3::ProjectionKind;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kStates = 16;

MatrixXd diagonal(const VectorXd& weights) { return weights.asDiagonal(); }

/// A numerical example of section VI at states evenly spread over its first trial.
Problem example_problem(const std::string& name, const std::string& scenario,
                        std::vector<std::string> overrides) {
  const example::Experiment experiment = example::load_experiment(config::Document::load(
      C3RT_SOURCE_DIRECTORY "/config/scenarios/" + scenario + ".yaml", overrides));
  Problem p{
      name, example::sizes(experiment), experiment.c3, experiment.costs, experiment.constraints,
      {}};
  // what every projection needs beside the published weights
  p.costs.convex.epsilon = 1e-6;
  p.settings.project_last = false;
  p.settings.trace = false;
  p.settings.fix_lambda_0 = false;  // Algorithm 1 as printed

  example::C3Controller controller(experiment);
  example::LcsPlant plant(experiment);
  const MatrixXd x = example::run(experiment, 1, 0, controller, plant).x;
  for (int i = 0; i < kStates; ++i) {
    const VectorXd x0 = x.col(i * (x.cols() - 1) / kStates);
    p.states.push_back({x0, experiment.x_desired, example::planning_system(experiment, x0)});
  }
  return p;
}

c3::Settings ball_settings(double rho_scale) {
  return {3,
          1.0,
          rho_scale,
          c3::QpBackend::kDirect,
          {4000, 1e-7, 0.1, 50, false},
          ProjectionKind::kMiqp,
          100000,
          true};
}

/// A push: the gap closes and the ball starts to roll, so that the contacts' modes change.
VectorXd one_ball_state(int i) { return rolling_ball::state(-0.0005 + 0.001 * i, 0.01 * i); }

Problem one_ball() {
  Problem p{"1_ball",
            rolling_ball::sizes(),
            ball_settings(2.2),
            rolling_ball::costs(rolling_ball::Phase::kRoll),
            {},
            {}};
  // C3+: per contact, in the order γ (2), normal (2), tangential (4 each)
  VectorXd g_lambda = VectorXd::Constant(12, 0.01);
  g_lambda[3] = 1e-7;
  g_lambda.tail(4).setConstant(1e-7);
  p.costs.plus = {g_lambda, VectorXd::Constant(12, 0.1), VectorXd::Ones(12), VectorXd::Ones(12)};
  for (int i = 0; i < kStates; ++i) {
    const VectorXd x = one_ball_state(i);
    p.states.push_back({x, rolling_ball::x_desired(x).col(0), rolling_ball::lcs(x)});
  }
  return p;
}

/// The same task with Anitescu's contacts (8 λ), which the convex projection needs.
Problem one_ball_anitescu() {
  using L = model::BallLayout;
  Problem p = one_ball();
  p.sizes.n_lambda = 8;
  p.settings.rho_scale = 3.0;
  p.costs.G = diagonal(VectorXd::Constant(p.sizes.n_z(), 1e-4));
  p.costs.U = MatrixXd();
  p.costs.plus = {};
  p.costs.convex = {100.0 * MatrixXd::Identity(19, 19), MatrixXd::Identity(3, 3), 0.5, 1e-6};
  const model::BallModelParameters parameters{
      0.01, rolling_ball::kPointRadius, 0.132, rolling_ball::kBallRadius, 0.0, 1.0, 1.0};
  for (State& state : p.states) {
    const VectorXd& x = state.x0;
    scene::Scene scene;
    scene.effector = {x.segment<3>(L::p_WE), x.segment<3>(L::v_WE)};
    scene.body(0) = {x.segment<3>(L::p_WB), Eigen::Quaterniond(x[3], x[4], x[5], x[6]),
                     x.segment<3>(L::v_WB), x.segment<3>(L::omega_WB)};
    state.lcs = model::anitescu(model::ball_contact_system(parameters, scene), 0.1);
    lcs::scale_forces(state.lcs, lcs::force_scale(state.lcs));
  }
  return p;
}

/// Two or three balls in a heap, the published starts and weights; the end effector pushes the
/// first one to its target.
Problem several_balls(int balls) {
  const model::BallsLayout layout{balls};
  const bool two = balls == 2;
  const double r = rolling_ball::kBallRadius, tip = rolling_ball::kPointRadius;
  model::BallsModelParameters parameters{0.01, tip, 0.0, 1.0, 1.0, {}};
  VectorXd x = VectorXd::Zero(layout.n_x()), Q = VectorXd::Constant(layout.n_x(), 0.1);
  Q.head(3).setOnes();
  Q.segment(layout.v_WE(), 3).setConstant(10.0);
  const Eigen::Vector2d starts[] = {{0.55, 0.1}, {two ? 0.55 : 0.53, 0.027}, {0.623, 0.027}};
  const Eigen::Vector2d weights[] = {
      {5e5, two ? 5e5 : 2e6}, {1e5, two ? 1e5 : 2.5e5}, {1e5, 2.5e5}};
  for (int i = 0; i < balls; ++i) {
    parameters.balls.push_back({0.132, r});
    x.segment<2>(layout.p_WB(i)) = starts[i];
    Q.segment<2>(layout.p_WB(i)) = weights[i];
  }

  Problem p{std::to_string(balls) + "_balls", {}, ball_settings(3.0), {}, {}, {}};
  const int pairs = balls == 2 ? 3 : 6;
  p.sizes = {layout.n_x(), two ? 6 * pairs : 4 * pairs, 3, 5};
  p.costs.Q = diagonal(Q);
  p.costs.Q_N = diagonal(Q);
  p.costs.R = 0.01 * MatrixXd::Identity(3, 3);
  p.costs.G = diagonal(VectorXd::Constant(p.sizes.n_z(), two ? 0.01 : 0.0005));
  VectorXd U = VectorXd::Ones(p.sizes.n_z());
  p.sizes.x(U).setConstant(100.0);
  p.costs.U = diagonal(U);
  if (!two) {
    p.costs.convex = {100.0 * MatrixXd::Identity(18, 18), MatrixXd::Identity(3, 3), 0.2, 1e-6};
  }
  const VectorXd ones = VectorXd::Ones(p.sizes.n_lambda);
  p.costs.plus = {(two ? 0.01 : 0.0005) * ones, 0.1 * ones, ones, ones};

  for (int i = 0; i < kStates; ++i) {
    const Eigen::Vector3d away = Eigen::Vector3d(0.3, 0.8, 0.5).normalized();
    x.head<3>() << x.segment<2>(layout.p_WB(0)), r;
    x.head<3>() += (r + tip - 0.0005 + 0.001 * i) * away;
    for (int b = 0; b < balls; ++b) x.segment<2>(layout.v_WB(b)) << 0.0, -0.01 * i / (1.0 + b);
    VectorXd target = VectorXd::Zero(layout.n_x());
    target.head<3>() << x.segment<2>(layout.p_WB(0)), tip + 2.0 * r + 0.004;
    for (int b = 0; b < balls; ++b) {
      target.segment<2>(layout.p_WB(b)) << 0.55, x[layout.p_WB(b) + 1] - 0.01;
    }
    const model::ContactSystem system =
        model::balls_contact_system(parameters, model::all_contact_pairs(balls), x);
    State state{x, target,
                two ? model::stewart_trinkle(system, 0.1) : model::anitescu(system, 0.1)};
    lcs::scale_forces(state.lcs, lcs::force_scale(state.lcs));
    p.states.push_back(std::move(state));
  }
  return p;
}

Problem make(const std::string& name) {
  if (name == "cart_pole") return example_problem(name, name, {});
  if (name == "gaiting") {
    return example_problem(name, "finger_gaiting",
                           {"c3.admm_iterations=5", "c3.rho_scale=1.01",
                            "start.x0=[-8, 0, 3, 0, 4, 0]", "start.spread_max=[0, 0, 0, 0, 0, 0]"});
  }
  if (name == "pivoting") {
    return example_problem(name, name, {"model.equations=as_published", "control.duration_s=1.5"});
  }
  if (name == "1_ball") return one_ball();
  if (name == "1_ball_anitescu") return one_ball_anitescu();
  if (name == "2_balls") return several_balls(2);
  if (name == "3_balls") return several_balls(3);
  throw std::invalid_argument("no problem is named " + name);
}

}  // namespace

Problem problem(const std::string& name, c3::ProjectionKind projection, int N) {
  static std::map<std::string, Problem> made;
  const bool convex_ball = name == "1_ball" && projection == ProjectionKind::kConvex;
  const std::string key = convex_ball ? "1_ball_anitescu" : name;
  if (made.count(key) == 0) made.emplace(key, make(key));
  Problem p = made.at(key);
  p.settings.projection = projection;
  p.sizes.N = N;
  return p;
}

}  // namespace bench
