#include "controller/example/load_experiment.hpp"

#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "controller/lcs/lcs.hpp"
#include "controller/model/registry.hpp"

using namespace c3rt;
using Catch::Matchers::Contains;

namespace {

example::Experiment load(const std::string& name, const std::vector<std::string>& overrides) {
  // what comes with a model of its own stands beside it
  const std::string file =
      name == "mechanism" ? "/examples/pusher/pusher.yaml" : "/config/scenarios/" + name + ".yaml";
  return example::load_experiment(config::Document::load(C3RT_SOURCE_DIRECTORY + file, overrides));
}

/// As a program does: what nobody has read is refused.
void load_strictly(const std::string& name, const std::string& override_text) {
  config::Section root = config::Document::load(
      C3RT_SOURCE_DIRECTORY "/config/scenarios/" + name + ".yaml", {override_text, "criteria=[]"});
  (void)root.name("name");
  (void)root.text("description");
  (void)root.list("criteria", 0, 0);
  (void)example::load_experiment(root);
  root.finish();
}

}  // namespace

TEST_CASE("example scenario: weights without a Riccati solution are refused by their key") {
  CHECK_THROWS_AS(load("cart_pole", {"weights.R.force=0"}), config::ConfigError);
  CHECK_THROWS_WITH(load("cart_pole", {"weights.R.force=0"}),
                    Contains("weights.Q_N: expected weights with a stabilising solution, or Q, got "
                             "riccati: R: expected a positive definite matrix"));
}

TEST_CASE("example scenario: weights are given by the names of the model, all and no others") {
  for (const model::SystemKind& kind : model::system_kinds()) {
    CAPTURE(kind.name);
    const example::Experiment experiment = load(kind.name, {});
    const model::SystemLayout& layout = experiment.model->layout();
    const lcs::Sizes sizes =
        lcs::sizes(experiment.model->planning_system(experiment.x0, experiment.planning_step));
    CHECK(layout.n_x() == sizes.n_x);
    CHECK(layout.n_lambda() == sizes.n_lambda);
    CHECK(layout.n_u() == sizes.n_u);
    for (int i = 0; i < layout.n_x(); ++i) {
      const std::string& name = layout.x[static_cast<std::size_t>(i)].name;
      const Eigen::MatrixXd changed = load(kind.name, {"weights.Q." + name + "=4321"}).costs.Q[0];
      Eigen::MatrixXd expected = experiment.costs.Q[0];
      expected(i, i) = 4321.0;
      CHECK(changed == expected);
    }
  }
  CHECK(load("pivoting", {}).costs.Q[0].diagonal().head<4>() == Eigen::Vector4d(100, 11, 100, 9));
  CHECK_THROWS_WITH(load_strictly("cart_pole", "weights.Q.ball=1"),
                    Contains("weights.Q.ball: unknown key"));
  CHECK_NOTHROW(load_strictly("cart_pole", "weights.Q.angle=1"));
  CHECK_THROWS_WITH(load("pivoting", {"weights.R.normal_2=.nan"}), Contains("weights.R.normal_2"));
  CHECK_THROWS_WITH(load("pivoting", {"model.equations=right"}),
                    Contains("model.equations: expected one of corrected, as_published"));
  CHECK_THROWS_WITH(
      load("pivoting", {"example=chess"}),
      Contains("example: expected one of cart_pole, finger_gaiting, mechanism, pivoting"));
}

TEST_CASE("example scenario: a QP step that cannot hold the constraints is refused by its key") {
  CHECK_THROWS_AS(load("finger_gaiting", {"c3.qp=direct"}), config::ConfigError);
  CHECK_THROWS_WITH(load("finger_gaiting", {"c3.qp=direct"}),
                    Contains("c3.qp: expected interior_point or osqp"));
  CHECK_NOTHROW(load("pivoting", {"c3.qp=direct"}));
}

TEST_CASE(
    "example scenario: what is not chosen may be absent, and is asked for where it is chosen") {
  const auto error = [](const std::string& changes, const std::vector<std::string>& overrides) {
    try {
      (void)example::load_experiment(config::Document::parse(
          "name: own\ndescription: none\nextends: cart_pole\n" + changes, "own.yaml", overrides));
    } catch (const config::ConfigError& refused) {
      return std::string(refused.what());
    }
    return std::string("no error");
  };
  const std::string rows[][3] = {
      {"weights: {plus: ~}\n", "c3.projection=plus",
       "weights.plus: missing, projection plus needs it"},
      {"weights: {convex: ~}\n", "c3.projection=convex",
       "weights.convex: missing, projection convex needs it"},
      {"weights: {U: ~}\n", "c3.projection=admm", "weights.U: missing, projection admm needs it"},
      {"c3: {projection: plus}\nweights: {G: ~}\n", "c3.projection=lcp",
       "weights.G: missing, projection lcp needs it"},
      {"c3: {max_nodes: ~}\n", "c3.projection=miqp",
       "c3.max_nodes: missing, projection miqp needs it"},
      {"c3: {osqp: ~}\n", "c3.qp=osqp", "c3.osqp: missing, qp osqp needs it"},
      {"c3: {start_reset_period_s: ~}\n", "c3.start=carried_forces",
       "c3.start_reset_period_s: missing, start carried_forces needs it"},
  };
  for (const auto& [absent, choice, message] : rows) {
    CAPTURE(absent, choice);
    CHECK(error(absent, {}) == "no error");
    CHECK_THAT(error(absent, {choice}), Contains(message));
  }
}
