#include "controller/c3/projection/registry.hpp"

#include <set>
#include <stdexcept>
#include <string>

#include <catch2/catch.hpp>

#include "controller/c3/consensus.hpp"
#include "controller/c3/projection.hpp"
#include "controller/c3/solver.hpp"

using namespace c3rt::c3;
using Catch::Matchers::Equals;

TEST_CASE("projections: each is found by its kind, and no two share a kind or a name") {
  std::set<ProjectionKind> kinds;
  std::set<std::string> keys, names;
  for (const auto type : kProjectionTypes) {
    CHECK(&projection_type(type().kind) == &type());
    CHECK(kinds.insert(type().kind).second);
    CHECK(keys.insert(type().key).second);
    CHECK(names.insert(type().problem_name).second);
  }
}

TEST_CASE("projections: a solver's copies have the rows that its projection works on") {
  const Sizes sizes{3, 2, 1, 4};
  for (const auto type : kProjectionTypes) {
    Settings settings{};
    settings.admm_iterations = settings.max_nodes = 1;
    settings.rho = settings.rho_scale = 1.0;
    settings.projection = type().kind;
    const bool appends_gaps = std::string(type().key) == "plus";
    CHECK(Solver(sizes, settings).n_copy() == (appends_gaps ? 8 : 6));
  }
}

TEST_CASE("projections: settings of one are refused by the one that needs them alone") {
  Settings settings{};
  settings.admm_iterations = settings.max_nodes = 1;
  settings.rho = settings.rho_scale = 1.0;
  settings.admm.iterations = 0;
  settings.projection = ProjectionKind::kAdmm;
  REQUIRE_THROWS_WITH(make_projection({1, 1, 1, 1}, settings),
                      Equals("Settings.admm.iterations: expected 1 or more, got 0"));
  settings.projection = ProjectionKind::kMiqp;
  REQUIRE_NOTHROW(make_projection({1, 1, 1, 1}, settings));
}

TEST_CASE("projections: what each says of its weights is all that its check asks for") {
  const Sizes sizes{3, 2, 1, 4};
  std::set<std::string> problem_names;
  for (const auto type : kProjectionTypes) {
    Costs costs;
    costs.Q = costs.Q_N = Eigen::MatrixXd(Eigen::MatrixXd::Identity(3, 3));
    costs.R = Eigen::MatrixXd(Eigen::MatrixXd::Identity(1, 1));
    costs.G = costs.U = Eigen::MatrixXd(Eigen::MatrixXd::Identity(6, 6));
    CAPTURE(type().key);
    if (!type().weights.empty()) CHECK_THROWS(check(costs, sizes, type().kind));
    std::set<std::string> keys;
    for (const ProjectionWeight& weight : type().weights) {
      CAPTURE(weight.key);
      CHECK(keys.insert(weight.key).second);
      CHECK(problem_names.insert(weight.problem_name).second);
      CHECK((weight.minimum <= 1.0 && 1.0 <= weight.maximum));
      weight.fill(costs, sizes, 1.0);
    }
    CHECK_NOTHROW(check(costs, sizes, type().kind));
  }
}
