#include "cli/example/tables.hpp"

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "cli/example/scenario.hpp"
#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli;
using Eigen::VectorXd;

ExampleScenario scenario(const std::string& name, const std::vector<std::string>& overrides) {
  return load_example(C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml", overrides);
}

bool never() { return false; }

std::vector<std::vector<std::string>> rows_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream cells(line + ",");
    auto& row = rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
  }
  return rows;
}

}  // namespace

TEST_CASE("the cost that came is the accumulated cost of N control steps and the last state's") {
  // a control step is ten of the simulation: only every tenth state counts
  const example::Experiment e =
      scenario("cart_pole_hardware", {"control.duration_s=0.3", "start.trials=1"}).experiment;
  const TrialsResult result = run_trials(
      scenario("cart_pole_hardware", {"control.duration_s=0.3", "start.trials=1"}), 1, never);
  const VectorXd costs = actual_costs(e, result.first);
  REQUIRE(costs.size() == 30);
  for (Eigen::Index i = 0; i < 30; ++i) {
    if (i + 10 > 30) {
      CHECK(std::isnan(costs[i]));
      continue;
    }
    double sum = 0.0;
    for (Eigen::Index k = i; k < i + 10; ++k) {
      const VectorXd x = result.first.x.col(10 * k), u = result.first.u.col(10 * k);
      sum += x.dot(e.costs.Q[0] * x) + u.dot(e.costs.R[0] * u);
    }
    const VectorXd last = result.first.x.col(10 * (i + 10));
    CHECK(costs[i] == Approx(sum + last.dot(e.costs.Q_N * last)));
  }
}

TEST_CASE("decisions have a row for each control step, with what was asked for") {
  const Folder folder;
  const auto file = folder.path() / "decisions.csv";
  const ExampleScenario short_one = scenario("cart_pole", {"control.duration_s=0.1"});
  const TrialsResult traced = run_trials(short_one, 1, never, {{}, true});
  write_decisions(file, short_one.experiment, traced);
  auto rows = rows_of(file);
  REQUIRE(rows.size() == 11);
  CHECK(rows[0] == std::vector<std::string>{"t_s", "cost_to_go", "actual_cost", "solve_time_s",
                                            "projection_s", "projections_not_solved"});
  for (std::size_t i = 1; i < rows.size(); ++i) {
    // with as many digits as give the same number again
    CHECK(std::stod(rows[i][1]) == traced.first.cost_to_go[static_cast<Eigen::Index>(i - 1)]);
    CHECK(std::stod(rows[i][4]) > 0.0);
    CHECK(rows[i][5] == "0");
  }
  CHECK(rows[1][0] == "0");
  CHECK_FALSE(rows[1][2].empty());
  CHECK(rows[2][2].empty());  // the trial ends before ten more steps

  write_decisions(file, short_one.experiment, run_trials(short_one, 1, never, {60.0, false}));
  rows = rows_of(file);
  CHECK(rows[0].back() == "proven");
  CHECK(rows[1].back() == "1");
  write_decisions(file, short_one.experiment, run_trials(short_one, 1, never));
  CHECK(rows_of(file)[0].size() == 4);
}

TEST_CASE("the iterates of the first decision come nearer to complementarity, and to the answer") {
  const Folder folder;
  const auto file = folder.path() / "iterates.csv";
  // the cart moves to the right, the tip 1 cm from the right wall
  const ExampleScenario near =
      scenario("cart_pole_hardware",
               {"start.x0=[0.44, 0.1, 0.6, -0.2]", "start.trials=1", "control.duration_s=0.01"});
  const TrialsResult result = run_trials(near, 1, never, {{}, true});
  write_iterates(file, near.experiment, result);
  const auto rows = rows_of(file);
  REQUIRE(rows.size() == 1 + 10 * 10);  // iterations and stages
  CHECK(rows[0] == std::vector<std::string>{"iteration", "stage", "position_m", "angle_rad",
                                            "velocity_m_per_s", "rate_rad_per_s", "right_wall_n",
                                            "left_wall_n", "gap_of_right_wall", "gap_of_left_wall",
                                            "force_n"});
  std::vector<double> worst(11, 0.0);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto value = [&](std::size_t column) { return std::stod(rows[i][column]); };
    // of a soft wall the gap is the distance to it, and λ/k: (x − l θ) ≤ d + λ/k, here for θ small
    const double tip = value(2) - 0.6 * value(3);
    CHECK(value(8) == Approx(0.39 - tip + value(6) / 100.0).margin(1e-9));
    CHECK(value(9) == Approx(0.39 + tip + value(7) / 100.0).margin(1e-9));
    for (const std::size_t wall : {6, 7}) {
      double& largest = worst[std::stoul(rows[i][0])];
      largest = std::max(largest, std::abs(std::min(value(wall), value(wall + 2))));
    }
  }
  CHECK(worst[10] < 1e-2 * worst[1]);
  // what the last iteration wants is what was applied
  CHECK(std::stod(rows[91][10]) == Approx(result.first.u(0, 0)));
}

TEST_CASE("a trial's overshoot is how far it went beyond its limits") {
  const ExampleScenario gaiting =
      scenario("finger_gaiting", {"control.duration_s=0.5", "start.trials=1"});
  const TrialsResult result = run_trials(gaiting, 1, never);
  double largest = 0.0;
  for (const auto& [row, low, high] : {std::tuple{2, 1.0, 3.0}, std::tuple{4, 3.0, 5.0}}) {
    const auto finger = result.first.x.row(row).array();
    largest = std::max({largest, low - finger.minCoeff(), finger.maxCoeff() - high});
  }
  CHECK(largest > 0.0);
  CHECK(result.trials.at(0).overshoot == Approx(largest));
  // without limits there is none to go beyond
  const ExampleScenario free = scenario("cart_pole", {"control.duration_s=0.1"});
  CHECK(run_trials(free, 1, never).trials.at(0).overshoot == 0.0);
}
