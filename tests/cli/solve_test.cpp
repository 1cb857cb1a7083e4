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
    write(problem);
    return solve_file(path("problem.json"), more);
  }
  void write(const Json& problem) const { std::ofstream(path("problem.json")) << problem.dump(); }
  Outcome solve_file(const fs::path& file, const std::string& more = "") const {
    return run(command(file) + " " + more);
  }
  static std::string command(const fs::path& file) {
    return "'" C3RT_BINARY_DIRECTORY "/bin/c3rt' solve '" + file.string() + "'";
  }
  /// What the command redirects itself is not seen here.
  Outcome run(const std::string& command) const {
    const int status = std::system(
        ("exec >'" + path("stdout").string() + "' 2>'" + path("stderr").string() + "'; " + command)
            .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(path("stdout")),
            read(path("stderr"))};
  }
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  auto count() const {
    return std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
  }

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
                                                 "objective", "qp_dual_residual",
                                                 "qp_primal_residual", "schema", "solve_time_s",
                                                 "status", "u", "u0", "x"});
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
    CHECK(keys(iterate) == std::vector<std::string>{"delta", "proj", "qp_dual_residual",
                                                    "qp_primal_residual", "rho", "w", "xN", "z"});
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

TEST_CASE("solve: the monolithic problem of an unstable system over a long horizon") {
  Json json = problem();
  json["method"] = "MIQP15";
  json["lcs"]["A"] = {{2}};
  json["params"]["N"] = 20;
  const Outcome outcome = Place().solve(json);
  CHECK(outcome.status == 0);
  const Json result = Json::parse(outcome.output);
  CHECK(result["status"] == "ok");
  CHECK(result["objective"].get<double>() == Approx(0.59678083).epsilon(1e-7));
  CHECK(result["u0"][0].get<double>() == Approx(-1.70893).epsilon(1e-5));
  CHECK(result["gap"].get<double>() <= 1.01e-7);
  CHECK(result["lower_bound"].get<double>() <= result["objective"].get<double>());
}

TEST_CASE("solve: the monolithic problem of the ball, whatever the units of its forces") {
  const Json newtons =
      Json::parse(read(C3RT_SOURCE_DIRECTORY "/tests/data/cases/miqp15_ball_N1.json"));
  for (const double s : {1.0, 6.465e-4, 1e-7, 1e5}) {
    INFO("s = " << s);
    Json json = newtons;
    Json& lcs = json["lcs"];
    for (Json& row : lcs["D"])
      for (Json& entry : row) entry = entry.get<double>() * s;
    for (const char* block : {"E", "H"})
      for (Json& row : lcs[block])
        for (Json& entry : row) entry = entry.get<double>() / s;
    for (Json& entry : lcs["c"]) entry = entry.get<double>() / s;
    const Outcome outcome = Place().solve(json);
    CHECK(outcome.status == 0);
    const Json result = Json::parse(outcome.output);
    CHECK(result["status"] == "ok");
    CHECK(result["objective"].get<double>() == Approx(630.5154938).epsilon(2e-7));
  }
}

TEST_CASE("solve: a monolithic problem without a trajectory is told from one not found in time") {
  Json json = problem();
  json["method"] = "MIQP15";
  json["params"].update({{"umin", {5}}, {"xmax", {0.1}}});
  json["lcs"]["D"] = {{0}};
  const Outcome none = Place().solve(json);
  CHECK(none.status == 1);
  CHECK(Json::parse(none.output)["status"] ==
        "fail: infeasible: no trajectory meets the constraints");
  Json late = problem();
  late["method"] = "MIQP15";
  late["deadline_s"] = 0;
  const Outcome stopped = Place().solve(late);
  CHECK(stopped.status == 4);
  CHECK(Json::parse(stopped.output)["status"] ==
        "fail: stopped by the deadline after 0 QPs: no plan was found");
}

TEST_CASE("solve: a problem without an answer exits with 1 and says why") {
  Json json = problem();
  json["params"].update({{"umin", {5}}, {"xmax", {0.1}}});
  json["lcs"]["D"] = {{0}};  // else the QP's lambda, of any sign, meets the bounds
  const Outcome outcome = Place().solve(json);
  CHECK(outcome.status == 1);
  CHECK(Json::parse(outcome.output)["status"] == "fail: the bounds cannot be met");
  CHECK_THAT(outcome.error, Contains("fail: the bounds cannot be met") && !Contains("u_0"));
}

TEST_CASE("solve: an answer whose projections ended at max_nodes is truncated and says so") {
  Json json = problem();
  json["lcs"] = Json::parse(R"({"A": [[1.1]], "B": [[0.5]], "D": [[-0.8, 0.8, -0.2, 0.6]], "d": [0],
    "E": [[0.8], [-0.6], [-0.2], [-0.8]], "H": [[-0.8], [1.0], [0.0], [0.4]], "c": [0.6, -0.8, 0.0, 0.2],
    "F": [[1.62, 0.04, -0.64, 0.32], [0.04, 1.1, 0.48, 0.2], [-0.64, 0.48, 1.46, 0.32],
          [0.32, 0.2, 0.32, 1.62]]})");
  const Json one = Json::parse(R"([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0],
                                   [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]])");
  json["params"].update({{"G", one}, {"U", one}});
  int truncated = 0;
  for (const int max_nodes : {1, 3, 4, 6, 100}) {
    json["params"]["max_nodes"] = max_nodes;
    const Outcome outcome = Place().solve(json);
    const std::string status = Json::parse(outcome.output)["status"];
    const std::string limit = "max_nodes = " + std::to_string(max_nodes);
    CAPTURE(max_nodes, status, outcome.error);
    CHECK((status == "ok") == (max_nodes == 100));
    CHECK(outcome.status == (status == "truncated" || status == "ok" ? 0 : 1));
    if (status != "ok") CHECK_THAT(outcome.error, Contains(limit));
    truncated += status == "truncated";
  }
  CHECK(truncated > 0);
}

TEST_CASE("solve: a convex projection that cannot be says why") {
  Json json = problem();
  json["projection"] = "CONVEX";
  json["lcs"]["F"] = {{-1}};
  json["params"].update({{"Qx", {{9}}}, {"Qu", {{1}}}, {"alpha", 0.1}});
  const Outcome outcome = Place().solve(json);
  CHECK(outcome.status == 1);
  CHECK_THAT(outcome.error,
             Contains("F + eps I positive semidefinite") && Contains("smallest eigenvalue is -1"));
}

TEST_CASE("solve: a result that does not get to standard output is not exit status 0") {
  const Place place;
  place.write(problem());
  const std::string command = place.command(place.path("problem.json"));
  const Outcome full = place.run(command + " >/dev/full");
  CHECK(full.status == 3);
  CHECK_THAT(full.error, Contains("cannot write the result to standard output: No space left"));
  const Outcome closed = place.run(command + " >&-");
  CHECK(closed.status == 3);
  CHECK_THAT(closed.error, Contains("cannot write the result to standard output: Bad file"));
  // and neither does the problem, which would be the first file to be opened
  CHECK(Json::parse(read(place.path("problem.json"))) == problem());
  CHECK(place.run("'" C3RT_BINARY_DIRECTORY "/bin/c3rt' --help >/dev/full").status == 3);
  // an answer without its line for a person is one
  CHECK(place.run(command + " 2>&- >'" + place.path("out").string() + "'").status == 0);
  CHECK(Json::parse(read(place.path("out")))["status"] == "ok");
}

TEST_CASE("solve: --out cannot be the problem, under no name") {
  const Place place;
  place.write(problem());
  const fs::path file = place.path("problem.json");
  fs::create_symlink(file, place.path("link.json"));
  fs::create_hard_link(file, place.path("hard.json"));
  fs::create_directory(place.path("folder"));
  for (const fs::path& out : {file, place.path("link.json"), place.path("hard.json"),
                              place.path("folder") / ".." / "problem.json"}) {
    const Outcome outcome = place.solve_file(file, "--out '" + out.string() + "'");
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.error, Contains("--out: expected another file than the problem's"));
    CHECK(place.solve_file(out, "--out '" + file.string() + "'").status == 2);
    CHECK(Json::parse(read(file)) == problem());
  }
}

TEST_CASE("solve: --out is refused before the work where it cannot be written") {
  const Place place;
  const Outcome folder = place.solve(problem(), "--out '" + place.path("").string() + "'");
  CHECK(folder.status == 2);
  CHECK_THAT(folder.error, Contains("--out: expected a file that can be written, not a folder"));
  const Outcome nowhere = place.solve(problem(), "--out /nowhere/result.json");
  CHECK(nowhere.status == 2);
  CHECK_THAT(nowhere.error, Contains("--out: expected a file in a folder that exists"));
}

TEST_CASE("solve: a result file is written whole or not at all") {
  const Place place;
  place.write(problem());
  const fs::path file = place.path("problem.json"), out = place.path("result.json");
  // no more than 64 blocks of 512 or 1024 bytes, which the trace exceeds
  Json traced = problem();
  traced["trace"] = true;
  traced["params"].update({{"s", 200}, {"rho_s", 1.01}});
  std::ofstream(file) << traced.dump();
  std::ofstream(out) << "earlier";
  const Outcome full = place.run("(ulimit -f 64; trap '' XFSZ; exec " + place.command(file) +
                                 " --out '" + out.string() + "')");
  CHECK(full.status == 3);
  CHECK_THAT(full.error, Contains("cannot write " + out.string() + ": File too large"));
  CHECK(read(out) == "earlier");
  CHECK(place.count() == 4);  // the problem, that result, the two streams
  // a device takes it as it is
  const Outcome device = place.solve_file(file, "--out /dev/full");
  CHECK(device.status == 3);
  CHECK_THAT(device.error, Contains("cannot write /dev/full: No space left"));
  // a link stays one
  fs::create_symlink("result.json", place.path("link.json"));
  CHECK(place.solve_file(file, "--out '" + place.path("link.json").string() + "'").status == 0);
  CHECK(fs::is_symlink(place.path("link.json")));
  CHECK(Json::parse(read(out))["status"] == "ok");
}

TEST_CASE("solve: a folder in the place of the problem is named, with exit status 2") {
  const Place place;
  const Outcome outcome = place.solve_file(place.path(""));
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.error, Contains("expected a problem file, got a folder"));
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
