// c3rt solve as a script meets it: exit status, standard output, result file.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "tests/cli/folder.hpp"

namespace {

using namespace c3rt::cli;
using Catch::Contains;
using Json = nlohmann::json;
namespace fs = std::filesystem;

struct Outcome {
  int status;
  std::string output, error;
};

std::string read(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

class Place {
 public:
  /// @param more options behind the problem's path
  Outcome solve(const Json& problem, const std::string& more = "") const {
    std::ofstream(path("problem.json")) << problem.dump();
    return solve_file(path("problem.json"), more);
  }
  Outcome solve_file(const fs::path& file, const std::string& more = "") const {
    const std::string command = "'" C3RT_BINARY_DIRECTORY "/bin/c3rt' solve '" + file.string() +
                                "' " + more + " >'" + path("stdout").string() + "' 2>'" +
                                path("stderr").string() + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(path("stdout")),
            read(path("stderr"))};
  }
  fs::path path(const std::string& name) const { return folder_.path() / name; }

 private:
  Folder folder_;
};

Json problem() {
  return Json::parse(R"({
    "schema": "c3-problem-1", "projection": "MIQP", "x0": [0.5],
    "lcs": {"A": [[1.1]], "B": [[0.5]], "D": [[0.1]], "d": [0], "E": [[1]], "F": [[1]], "H": [[0]],
            "c": [-0.2]},
    "params": {"N": 3, "s": 4, "rho": 0.1, "rho_s": 2, "Q": [[1]], "R": [[0.1]], "QN": [[2]],
               "xd": [0], "G": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
               "U": [[9, 0, 0], [0, 1, 0], [0, 0, 1]]}})");
}

std::vector<std::string> keys(const Json& json) {
  std::vector<std::string> found;
  for (const auto& item : json.items()) found.push_back(item.key());
  return found;
}

}  // namespace

TEST_CASE("solve: an answer is pure JSON on standard output, with the keys of the schema") {
  const Outcome outcome = Place().solve(problem());
  CHECK(outcome.status == 0);
  const Json result = Json::parse(outcome.output);
  CHECK(keys(result) == std::vector<std::string>{"complementarity_violation", "iterations", "lam",
                                                 "objective", "schema", "solve_time_s", "status",
                                                 "u", "u0", "x"});
  CHECK(result["schema"] == "c3-result-1");
  CHECK(result["status"] == "ok");
  CHECK(result["solve_time_s"] > 0.0);
  CHECK_THAT(outcome.error, Contains("ok: u_0 ="));
}

TEST_CASE("solve: a trace holds every iterate") {
  Json traced = problem();
  traced["trace"] = true;
  const Json result = Json::parse(Place().solve(traced).output);
  REQUIRE(result["iters"].size() == 4);
  for (const Json& iterate : result["iters"]) {
    CHECK(keys(iterate) == std::vector<std::string>{"delta", "proj", "rho", "w", "xN", "z"});
  }
  CHECK(result["iters"][3]["xN"] == result["x"][3]);
}

TEST_CASE("solve: --out writes the file and leaves standard output empty") {
  const Place place;
  const fs::path out = place.path("result.json");
  const Outcome outcome = place.solve(problem(), "--out '" + out.string() + "'");
  CHECK(outcome.status == 0);
  CHECK(outcome.output.empty());
  CHECK(Json::parse(read(out))["status"] == "ok");
}

TEST_CASE("solve: any number of threads gives the same bits") {
  Json json = problem();
  json["trace"] = true;
  Json one = Json::parse(Place().solve(json).output);
  json["threads"] = 2;
  Json two = Json::parse(Place().solve(json).output);
  one.erase("solve_time_s");
  two.erase("solve_time_s");
  CHECK(one == two);
}

TEST_CASE("solve: a deadline that has passed gives a truncated answer, which is one") {
  Json json = problem();
  json["deadline_s"] = 0;
  const Outcome outcome = Place().solve(json);
  CHECK(outcome.status == 0);
  const Json result = Json::parse(outcome.output);
  CHECK(result["status"] == "truncated");
  CHECK(result["iterations"] == 1);
}

TEST_CASE("solve: the monolithic problem is no dearer than what C3 found") {
  Json json = problem();
  const Json c3 = Json::parse(Place().solve(json).output);
  json["method"] = "MIQP15";
  const Outcome outcome = Place().solve(json);
  CHECK(outcome.status == 0);
  const Json result = Json::parse(outcome.output);
  CHECK(result["status"] == "ok");
  CHECK(result["objective"].get<double>() <= c3["objective"].get<double>() + 1e-9);
  CHECK(result["complementarity_violation"].get<double>() < 1e-8);
}

TEST_CASE("solve: a problem without an answer exits with 1 and says why") {
  Json json = problem();
  json["params"].update({{"umin", {5}}, {"xmax", {0.1}}});
  json["lcs"]["D"] = {{0}};  // else the QP's lambda, of any sign, meets the bounds
  const Outcome outcome = Place().solve(json);
  CHECK(outcome.status == 1);
  CHECK(Json::parse(outcome.output)["status"] == "fail: the bounds cannot be met");
}

TEST_CASE("solve: what is wrong with a file is named by its key, with exit status 2") {
  Json json = problem();
  json["params"]["G"][0][0] = -1;
  const Place place;
  const Outcome outcome = place.solve(json);
  CHECK(outcome.status == 2);
  CHECK(outcome.output.empty());
  CHECK_THAT(
      outcome.error,
      Contains("c3rt: error: ") &&
          Contains("params.G: expected a positive semidefinite matrix, got the eigenvalue -1"));
  const Outcome missing = place.solve_file("/nowhere/problem.json");
  CHECK(missing.status == 2);
  CHECK_THAT(missing.error, Contains("/nowhere/problem.json: expected a file that can be read"));
  CHECK(place.solve(problem(), "--out /nowhere/result.json").status == 2);
  CHECK(place.solve(problem(), "--no-such-option").status == 2);
}
