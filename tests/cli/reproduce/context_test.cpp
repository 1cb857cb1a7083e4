#include "cli/reproduce/context.hpp"

#include <fstream>

#include <catch2/catch.hpp>

#include "cli/reproduce/loop.hpp"
#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli;
using namespace c3rt::cli::reproduce;

const std::string kCartPole = C3RT_SOURCE_DIRECTORY "/config/scenarios/cart_pole.yaml";

Settings settings(const Folder& folder) {
  Settings settings;
  settings.what = "test";
  settings.out = folder.path().string();
  return settings;
}

bool never() { return false; }

}  // namespace

TEST_CASE("a part is computed once, and anew where anything that it depends on has changed") {
  const Folder folder;
  const Settings plain = settings(folder);
  int computed = 0;
  const auto value = [&](const Settings& s, const Overrides& overrides,
                         const ordered_json& inputs) {
    return Context(s, never)
        .part("part", kCartPole, overrides, inputs,
              [&] {
                return ordered_json{{"n", ++computed}};
              })
        .at("n")
        .get<int>();
  };
  CHECK(value(plain, {}, {}) == 1);
  CHECK(value(plain, {}, {}) == 1);
  CHECK(value(plain, {"control.horizon=20"}, {}) == 2);
  CHECK(value(plain, {"control.horizon=20"}, {{"limit", 3}}) == 3);
  CHECK(value(plain, {"control.horizon=20"}, {{"limit", 3}}) == 3);
  Settings other = plain;
  other.quick = true;
  CHECK(value(other, {"control.horizon=20"}, {{"limit", 3}}) == 4);
  other.fresh = true;
  CHECK(value(other, {"control.horizon=20"}, {{"limit", 3}}) == 5);
}

TEST_CASE("a part is computed anew where what its scenario extends has changed") {
  const Folder folder;
  const std::string base = (folder.path() / "base.yaml").string();
  const std::string own = (folder.path() / "own.yaml").string();
  std::ofstream(own) << "extends: base.yaml\nx: 1\n";
  int computed = 0;
  const auto value = [&] {
    return Context(settings(folder), never)
        .part("part", own, {}, {}, [&] { return ordered_json(++computed); })
        .get<int>();
  };
  std::ofstream(base) << "y: 1\n";
  CHECK(value() == 1);
  CHECK(value() == 1);
  std::ofstream(base) << "y: 2\n";
  CHECK(value() == 2);
}

TEST_CASE("a part that was cut short by a crash is computed anew") {
  const Folder folder;
  const Context context(settings(folder), never);
  const auto compute = [] { return ordered_json{{"n", 7}}; };
  context.part("part", kCartPole, {}, {}, compute);
  std::ofstream(folder.path() / "parts" / "test-part.json") << "{\"key\": {";
  CHECK(context.part("part", kCartPole, {}, {}, compute).at("n") == 7);
}

TEST_CASE("a person's wish to end is heard before a part, and kept parts are given still") {
  const Folder folder;
  bool stop = false;
  const Context context(settings(folder), [&] { return stop; });
  const auto compute = [] { return ordered_json(1); };
  context.part("done", kCartPole, {}, {}, compute);
  stop = true;
  CHECK(context.part("done", kCartPole, {}, {}, compute) == 1);
  CHECK_THROWS_AS(context.part("other", kCartPole, {}, {}, compute), Interrupted);
}

TEST_CASE("the monolithic MIQP never plans a worse cost than C3") {
  const Folder folder;
  const Context context(settings(folder), never);
  const example::Experiment experiment = context.scenario(kCartPole, {}).experiment;
  example::C3Controller c3(experiment);
  MonolithicController miqp(experiment, experiment, 60.0, never);
  for (const Eigen::Vector4d& x :
       {Eigen::Vector4d(0.3, 0, 0.3, 0), Eigen::Vector4d(0.45, 0.1, 0.8, -0.5),
        Eigen::Vector4d(-0.4, 0.0, -1.0, 0.5), Eigen::Vector4d(0, 0, 0, 0)}) {
    const lcs::Lcs lcs = example::planning_system(experiment, x);
    const Eigen::MatrixXd* c3_inputs = c3.decide(lcs, x, 0.0);
    REQUIRE(c3_inputs != nullptr);
    const double c3_cost = example::cost_to_go(experiment, lcs, x, *c3_inputs);
    const Eigen::MatrixXd* inputs = miqp.decide(lcs, x, 0.0);
    REQUIRE(inputs != nullptr);
    // both within the search's gap of 1e-4
    CHECK(example::cost_to_go(experiment, lcs, x, *inputs) <= c3_cost * (1.0 + 1e-4) + 1e-6);
  }
  CHECK(miqp.proven() == 4);
}

TEST_CASE("a loop that is to end is interrupted, also within a decision") {
  const Folder folder;
  const Context context(settings(folder), [] { return true; });
  const ExampleScenario scenario = context.scenario(kCartPole, {});
  example::C3Controller controller(scenario.experiment);
  CHECK_THROWS_AS(run_loop(context, "loop", scenario, controller), Interrupted);
}
