// `c3rt gap` as a person meets it, beside closed forms and the exact solve of c3rt solve.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/folder.hpp"
#include "tests/support/outcome.hpp"

namespace {

using c3rt::cli::Folder;
using c3rt::support::Outcome;
using c3rt::support::outcome_of;
using Catch::Contains;
using nlohmann::json;
namespace fs = std::filesystem;

const std::string kProgram = "'" C3RT_BINARY_DIRECTORY "/bin/c3rt' ";

json read(const fs::path& file) { return json::parse(std::ifstream(file)); }

Outcome gap(const Folder& folder, const std::string& what) {
  return outcome_of(kProgram + "gap " + what + " --out '" + (folder.path() / "gap").string() + "'");
}
json states(const Folder& folder) { return read(folder.path() / "gap" / "gap.json").at("states"); }

/// A mass before a wall at 0 that is wanted behind it: x_1 = x_0 + u + λ, 0 ≤ λ ⊥ x_1 ≥ 0.
json wall(double x_0, double wanted) {
  return {{"schema", "c3-problem-1"},
          {"projection", "MIQP"},
          {"x0", {x_0}},
          {"lcs",
           {{"A", {{1.0}}},
            {"B", {{1.0}}},
            {"D", {{1.0}}},
            {"d", {0.0}},
            {"E", {{1.0}}},
            {"F", {{1.0}}},
            {"H", {{1.0}}},
            {"c", {0.0}}}},
          {"params",
           {{"N", 1},
            {"s", 2},
            {"rho", 1.0},
            {"rho_s", 2.0},
            {"Q", {{1.0}}},
            {"R", {{0.1}}},
            {"QN", {{1.0}}},
            {"xd", {wanted}},
            {"G", {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}},
            {"U", {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}}}}};
}

}  // namespace

TEST_CASE("the optimum of one wall is its closed form, and a plan's cost is what it brings") {
  const Folder folder;
  const fs::path file = folder.path() / "wall.json";
  std::ofstream(file) << wall(1.0, -1.0).dump();
  const Outcome outcome = gap(folder, "'" + file.string() + "'");
  INFO(outcome.output);
  REQUIRE(outcome.status == 0);
  const json state = states(folder).at(0);
  // at the wall: u = −1, x_1 = 0; the terms of x_0, x_1 and u
  CHECK(state.at("optimum").get<double>() == Approx(4.0 + 1.0 + 0.1).epsilon(1e-6));
  CHECK(state.at("lower_bound").get<double>() <= state.at("optimum").get<double>());
  CHECK(state.at("proven") == true);

  const fs::path result = folder.path() / "result.json";
  REQUIRE(outcome_of(kProgram + "solve '" + file.string() + "' --out '" + result.string() + "'")
              .status == 0);
  const double u = read(result).at("u").at(0).at(0), x_1 = std::max(0.0, 1.0 + u);
  const double cost = 4.0 + (x_1 + 1.0) * (x_1 + 1.0) + 0.1 * u * u;
  CHECK(state.at("cost").get<double>() == Approx(cost));
  CHECK(state.at("above").get<double>() == Approx(cost / 5.1 - 1.0).margin(1e-5));
}

TEST_CASE(
    "an example's plans: none is cheaper than a proven bound, and a trial gives the same again") {
  const Folder folder, other;
  const Outcome outcome = gap(folder, "cart_pole --states 4");
  INFO(outcome.output);
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("above the optimum"));
  const json all = states(folder);
  REQUIRE(all.size() == 4);
  for (const json& state : all) {
    CHECK(state.at("meets_constraints") == true);
    CHECK(state.at("cost").get<double>() >= state.at("lower_bound").get<double>());
    CHECK(state.at("optimum").get<double>() >= state.at("lower_bound").get<double>());
  }
  CHECK(all[1].at("time_s").get<double>() == Approx(0.01));
  REQUIRE(gap(other, "cart_pole --states 2").status == 0);
  for (const char* figure : {"cost", "optimum", "lower_bound"})
    CHECK(states(other)[1].at(figure) == all[1].at(figure));
}

TEST_CASE(
    "what follows a plan's first input is no better than the optimum and no worse than the plan") {
  const Folder folder;
  const fs::path file = folder.path() / "wall.json";
  std::ofstream(file) << wall(1.0, -1.0).dump();
  REQUIRE(gap(folder, "'" + file.string() + "' --first-input").status == 0);
  // the first input is all that there is
  const json one = states(folder).at(0);
  CHECK(one.at("first_input_above").get<double>() ==
        Approx(one.at("above").get<double>()).margin(1e-5));

  const Outcome outcome = gap(folder, "cart_pole --states 2 --first-input");
  INFO(outcome.output);
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("first input"));
  for (const json& state : states(folder)) {
    const double first = state.at("first_input_above");
    CHECK(first >= -1e-6);
    if (state.at("meets_constraints") == true) CHECK(first <= state.at("above").get<double>());
  }
}

TEST_CASE("another planner of an example answers for the same states") {
  const Folder folder;
  const fs::path file = folder.path() / "polished.yaml";
  std::ofstream(file)
      << "name: polished\ndescription: polished\nextends: cart_pole\nc3: {polish: 40}\n";
  const Outcome outcome =
      gap(folder, "cart_pole --states 4 --planner cart_pole --planner '" + file.string() + "'");
  INFO(outcome.output);
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("by cart_pole") && Contains("by polished"));
  for (const json& state : states(folder)) {
    const json &same = state.at("planners").at("cart_pole"),
               &polished = state.at("planners").at(file.string());
    CHECK(same.at("cost") == state.at("cost"));
    CHECK(polished.at("cost").get<double>() <= state.at("cost").get<double>() * (1.0 + 1e-9));
    CHECK(polished.at("cost").get<double>() >= state.at("lower_bound").get<double>());
  }

  std::ofstream(file)
      << "name: longer\ndescription: longer\nextends: cart_pole\ncontrol: {horizon: 11}\n";
  const Outcome refused = gap(folder, "cart_pole --states 1 --planner '" + file.string() + "'");
  CHECK(refused.status == 2);
  CHECK_THAT(refused.output, Contains("a horizon of 10 and") && Contains("got 4 states, 1 inputs"));
}

TEST_CASE("a search that its limit ends is said, with exit status 4") {
  const Folder folder;
  const Outcome outcome =
      gap(folder, "finger_gaiting --states 1 --limit 0.001 --relative-gap 1e-6");
  INFO(outcome.output);
  CHECK(outcome.status == 4);
  CHECK(states(folder).at(0).at("proven") == false);
}

TEST_CASE("what is no problem and no example is refused") {
  const Folder folder;
  for (const auto& [what, says] : {std::pair{"circle_slow", "is no example"},
                                   {"no_such", "cart_pole"},
                                   {"no.json", "expected a file that can be read"},
                                   {"cart_pole --states 0", "--states"},
                                   {"cart_pole --set c3.no=1", "c3.no"},
                                   {"cart_pole --planner circle_slow", "a numerical example"},
                                   {"cart_pole --planner pivoting", "expected 4 states"}}) {
    const Outcome outcome = gap(folder, what);
    CAPTURE(what, outcome.output);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains(says));
  }
}
