// The LCS builders of the numerical examples against recorded matrices of independent code.
#include <cmath>
#include <cstdlib>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "controller/lcs/riccati.hpp"
#include "controller/lcs/simulate.hpp"
#include "controller/model/cart_pole.hpp"
#include "controller/model/finger_gaiting.hpp"
#include "controller/model/pivoting.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::json;

namespace {

Json load(const std::string& example) {
  // another folder of the same kind may be named, see tests/data/golden
  const char* elsewhere = std::getenv("C3RT_GOLDEN");
  const std::string folder =
      elsewhere != nullptr ? elsewhere : C3RT_SOURCE_DIRECTORY "/tests/data/golden";
  std::ifstream file(folder + "/" + example + ".json");
  REQUIRE(file.good());
  return Json::parse(file);
}

VectorXd vector(const Json& json) {
  VectorXd v(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) v[static_cast<Eigen::Index>(i)] = json[i];
  return v;
}

MatrixXd matrix(const Json& json) {
  MatrixXd m(json.size(), json.at(0).size());
  for (std::size_t i = 0; i < json.size(); ++i)
    m.row(static_cast<Eigen::Index>(i)) = vector(json[i]);
  return m;
}

// 1e-12, and what the twelve digits of the files leave out of numbers above 1
void check_equal(const std::string& name, const MatrixXd& ours, const MatrixXd& recorded) {
  INFO(name << "\n" << ours << "\nexpected\n" << recorded);
  REQUIRE(ours.rows() == recorded.rows());
  REQUIRE(ours.cols() == recorded.cols());
  for (Eigen::Index i = 0; i < ours.size(); ++i)
    CHECK(std::abs(ours(i) - recorded(i)) <= 1e-12 + (std::abs(recorded(i)) > 1.0 ? 5e-12 : 0.0));
}

void check_equal(const lcs::Lcs& ours, const Json& recorded) {
  lcs::check(ours);
  check_equal("A", ours.A, matrix(recorded["A"]));
  check_equal("B", ours.B, matrix(recorded["B"]));
  check_equal("D", ours.D, matrix(recorded["D"]));
  check_equal("d", ours.d, vector(recorded["d"]));
  check_equal("E", ours.E, matrix(recorded["E"]));
  check_equal("F", ours.F, matrix(recorded["F"]));
  check_equal("H", ours.H, matrix(recorded["H"]));
  check_equal("c", ours.c, vector(recorded["c"]));
}

}  // namespace

TEST_CASE("cart pole: its LCS is the recorded one") {
  check_equal(model::cart_pole(model::CartPoleParameters::simulated(), 0.01),
              load("cartpole")["lcs_const"]);
}

TEST_CASE("cart pole: the walls of the experiment stand further away and are stiffer") {
  using L = model::CartPoleLayout;
  const lcs::Lcs lcs = model::cart_pole(model::CartPoleParameters::hardware(), 0.01);
  // cart and tip 0.02 m into the right wall: 2 N, to the left
  const VectorXd x = (VectorXd(4) << 0.41, 0.0, 0.0, 0.0).finished();
  const lcs::Simulation result = lcs::simulate(lcs, x, MatrixXd::Zero(1, 1));
  REQUIRE(result.report.ok());
  CHECK(result.lambda(L::right_wall, 0) == Approx(2.0));
  CHECK(result.lambda(L::left_wall, 0) == 0.0);
}

TEST_CASE("cart pole: the terminal weight has the digits of its Riccati equation") {
  const lcs::Lcs lcs = model::cart_pole(model::CartPoleParameters::simulated(), 0.01);
  const VectorXd Q = (VectorXd(4) << 10.0, 3.0, 1.0, 1.0).finished();
  const MatrixXd P =
      lcs::riccati(lcs.A, lcs.B, Q.asDiagonal().toDenseMatrix(), MatrixXd::Identity(1, 1));
  // computed elsewhere with three digits after the point
  MatrixXd expected(4, 4);
  expected << 1380.354, -2517.770, 895.787, -523.538,  //
      -2517.770, 15874.546, -2926.699, 3040.210,       //
      895.787, -2926.699, 970.893, -607.919,           //
      -523.538, 3040.210, -607.919, 597.261;
  CHECK((P - expected).cwiseAbs().maxCoeff() < 6e-4);
  const Json all = load("cartpole");
  REQUIRE(all["param_sets"].size() > 0);
  for (const auto& [name, parameters] : all["param_sets"].items()) {
    INFO(name);
    const MatrixXd recorded = matrix(parameters["QN"]);
    CHECK((P - recorded).norm() < 1e-9 * recorded.norm());
  }
}

TEST_CASE("finger gaiting: its LCS is the recorded one") {
  check_equal(model::finger_gaiting(model::FingerGaitingParameters::paper(), 0.1),
              load("finger")["lcs_const"]);
}

TEST_CASE("finger gaiting: an object held tightly follows the finger, held loosely it slips") {
  using L = model::FingerGaitingLayout;
  const double dt = 0.01, g = 9.81;
  const lcs::Lcs lcs = model::finger_gaiting(model::FingerGaitingParameters::paper(), dt);
  const VectorXd x = VectorXd::Zero(6);
  MatrixXd u = MatrixXd::Zero(4, 1);
  u(L::normal_1, 0) = 100.0;
  lcs::Simulation result = lcs::simulate(lcs, x, u);
  REQUIRE(result.report.ok());
  // two equal masses, one of them falling
  CHECK(result.x(L::object_rate, 1) == Approx(-0.5 * g * dt));
  CHECK(result.x(L::finger_1_rate, 1) == Approx(-0.5 * g * dt));
  CHECK(std::abs(result.x(L::finger_2_rate, 1)) < 1e-14);
  u(L::normal_1, 0) = 2.0;  // less friction than the 4.9 N that sticking needs
  result = lcs::simulate(lcs, x, u);
  REQUIRE(result.report.ok());
  CHECK(result.x(L::object_rate, 1) == Approx((2.0 - g) * dt));
  CHECK(result.x(L::finger_1_rate, 1) == Approx(-2.0 * dt));
}

TEST_CASE("pivoting: as published, its LCS is the recorded one at every recorded state") {
  model::PivotingParameters parameters = model::PivotingParameters::paper();
  parameters.equations = model::PivotingEquations::kAsPublished;
  int compared = 0;
  const Json all = load("pivoting");
  for (const Json& recorded : all["cases"]) {
    INFO(recorded["id"].get<std::string>());
    check_equal(model::pivoting(parameters, vector(recorded["x0"]), 0.01), recorded["lcs"]);
    ++compared;
  }
  CHECK(compared >= 2);
}

TEST_CASE("pivoting: ground friction slows a sliding box if corrected, and not as published") {
  using L = model::PivotingLayout;
  const double dt = 0.01, g = 9.81;
  VectorXd x = VectorXd::Zero(10);
  x[L::y] = std::sqrt(2.0);
  x[L::alpha] = std::atan(1.0);  // on its corner, the centre above it
  for (const double speed : {1.0, -1.0}) {
    x[L::x_rate] = speed;
    model::PivotingParameters parameters = model::PivotingParameters::paper();
    const double change = parameters.friction_3 * g * dt;
    lcs::Simulation result =
        lcs::simulate(model::pivoting(parameters, x, dt), x, MatrixXd::Zero(4, 1));
    REQUIRE(result.report.ok());
    CHECK(result.lambda(L::normal_ground, 0) == Approx(g));
    CHECK(result.x(L::x_rate, 1) == Approx(speed > 0 ? speed - change : speed + change));
    parameters.equations = model::PivotingEquations::kAsPublished;
    result = lcs::simulate(model::pivoting(parameters, x, dt), x, MatrixXd::Zero(4, 1));
    REQUIRE(result.report.ok());
    CHECK(result.x(L::x_rate, 1) == Approx(speed > 0 ? speed + change : speed - change));
  }
}

TEST_CASE("pivoting: corrected, both directions of each friction act alike on the box") {
  using L = model::PivotingLayout;
  VectorXd x = VectorXd::Zero(10);
  x[L::y] = 1.4;
  x[L::alpha] = 0.3;
  const lcs::Lcs lcs = model::pivoting(model::PivotingParameters::paper(), x, 0.01);
  for (const int plus : {L::t1_plus, L::t2_plus, L::t3_plus}) {
    CHECK(lcs.D.col(plus) == -lcs.D.col(plus + 1));
    CHECK(lcs.F(plus, plus) > 0.0);  // a friction force slows the slip that it answers
  }
}

TEST_CASE("pivoting: the ground's lever is the rate of the corner's height over the angle") {
  using L = model::PivotingLayout;
  VectorXd x = VectorXd::Zero(10);
  x[L::alpha] = 0.3;
  const auto gap = [&](double alpha) {
    VectorXd at = x;
    at[L::alpha] = alpha;
    return model::pivoting(model::PivotingParameters::paper(), at, 1e-9).c[L::normal_ground];
  };
  const double dt = 0.01;
  const lcs::Lcs lcs = model::pivoting(model::PivotingParameters::paper(), x, dt);
  CHECK(lcs.E(L::normal_ground, L::alpha_rate) / dt ==
        Approx((gap(0.3 + 1e-5) - gap(0.3 - 1e-5)) / 2e-5).epsilon(1e-8));
  // and the virtual work of the normal force agrees with it
  CHECK(lcs.D(L::alpha_rate, L::normal_ground) == Approx(lcs.E(L::normal_ground, L::alpha_rate)));
}
