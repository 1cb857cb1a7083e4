// `c3rt reproduce` as a person meets it.
#include "cli/reproduce/reproduce.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/folder.hpp"
#include "tests/support/outcome.hpp"

namespace {

using c3rt::cli::Folder;
using Catch::Contains;
using nlohmann::json;

using c3rt::support::Outcome;

Outcome reproduce(const Folder& folder, const std::string& arguments,
                  const std::string& prefix = "") {
  return c3rt::support::outcome_of(prefix + " '" C3RT_BINARY_DIRECTORY "/bin/c3rt' reproduce " +
                                   arguments + " --out '" + folder.path().string() + "'");
}

json results(const Folder& folder, const std::string& what) {
  return json::parse(std::ifstream(folder.path() / (what + ".json")));
}

}  // namespace

TEST_CASE("a table that the paper does not have is a usage error that lists those it has") {
  const Folder folder;
  const Outcome outcome = reproduce(folder, "table9");
  CHECK(outcome.status == 2);
  for (const std::string& name : c3rt::cli::reproduce::names())
    CHECK_THAT(outcome.output, Contains(name));
  CHECK(reproduce(folder, "").status == 2);
  CHECK(reproduce(folder, "table1 --miqp-limit -1").status == 2);
}

TEST_CASE("table3: every projection beside the paper's, in a table, a picture and a file") {
  const Folder folder;
  const Outcome outcome = reproduce(folder, "table3 --quick");
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("22.09") && Contains("24.98") && Contains("35.74"));
  CHECK(std::filesystem::exists(folder.path() / "table3.png"));
  const json table = results(folder, "table3");
  for (const char* projection : {"lcp", "miqp", "admm", "convex", "plus"}) {
    CAPTURE(projection);
    const json& row = table.at(projection);
    CHECK(row.at("calls") == 30);  // 0.3 s at 100 Hz
    CHECK(row.at("controller_failures") == 0);
    CHECK(row.at("projections_not_solved") == 0);
    CHECK(row.at("projection_s").at("mean").get<double>() > 0.0);
    CHECK(row.at("cost_to_go").size() == 30);
  }
  // what was measured is not measured again
  CHECK_THAT(reproduce(folder, "table3 --quick").output, Contains("lcp: kept from an earlier run"));
}

TEST_CASE("push_anything: each object's share of seeds that reached the goal, and what was left") {
  const Folder folder;
  const Outcome outcome = reproduce(folder, "push_anything --quick --seeds 1..2");
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("box") && Contains("26.9"));
  const json cases = results(folder, "push_anything").at("cases");
  REQUIRE(cases.size() == 2);
  for (const json& one : cases) {
    CHECK(one.at("runs") == 2);
    CHECK(one.at("goal_times_s").size() == one.at("reached"));
    CHECK(one.at("end_position_errors_mm").size() == 2);
  }
}

TEST_CASE("fig7: complementarity is violated less and less") {
  const Folder folder;
  REQUIRE(reproduce(folder, "fig7").status == 0);
  const json iterations = results(folder, "fig7").at("iterations");
  const auto worst = [&](const char* iteration) {
    double largest = 0.0;
    for (const json& value : iterations.at(iteration).at("violation"))
      largest = std::max(largest, value.get<double>());
    return largest;
  };
  CHECK(worst("10") < 1e-2 * worst("1"));
  CHECK(iterations.at("10").at("lambda_1_n").size() == 10);
}

TEST_CASE("an interrupted table ends at once with its parts kept, and the next call uses them") {
  const Folder folder;
  // the MIQP of N = 20 alone takes far longer
  const Outcome interrupted =
      reproduce(folder, "table1 --miqp-limit 60", "timeout --preserve-status -s INT 4");
  CHECK(interrupted.status == 1);
  CHECK_THAT(interrupted.output, Contains("interrupted"));
  REQUIRE(std::filesystem::exists(folder.path() / "parts" / "table1-c3-10.json"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "table1.json"));
  const Outcome again =
      reproduce(folder, "table1 --miqp-limit 60", "timeout --preserve-status -s INT 1");
  CHECK_THAT(again.output, Contains("c3-10: kept from an earlier run"));
}
