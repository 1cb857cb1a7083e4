// The problem file of c3rt solve: what is refused, with which words, and that what is read is
// solved.
#include "config/problem_file.hpp"

#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace c3rt;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
using config::parse_problem;
using config::ProblemFile;
using Json = nlohmann::json;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One state, one contact, one input, N = 3.
Json problem() {
  return Json::parse(R"({
    "schema": "c3-problem-1", "projection": "MIQP", "x0": [0.5],
    "lcs": {"A": [[1.1]], "B": [[0.5]], "D": [[0.1]], "d": [0], "E": [[1]], "F": [[1]], "H": [[0]],
            "c": [-0.2]},
    "params": {"N": 3, "s": 4, "rho": 0.1, "rho_s": 2, "Q": [[1]], "R": [[0.1]], "QN": [[2]],
               "xd": [0], "G": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
               "U": [[9, 0, 0], [0, 1, 0], [0, 0, 1]]}})");
}

Json plus_problem() {
  Json json = problem();
  json["projection"] = "C3+";
  json["params"].erase("G");
  json["params"].erase("U");
  json["params"].update({{"g_lambda", 1}, {"g_eta", 2}, {"u_lambda", 3}, {"u_eta", 4}});
  return json;
}

Json convex_problem() {
  Json json = problem();
  json["projection"] = "CONVEX";
  json["params"].update({{"Qx", {{9}}}, {"Qu", {{1}}}, {"alpha", 0.1}, {"eps", 0.01}});
  return json;
}

ProblemFile read(const Json& json) { return parse_problem(json.dump(), "p.json"); }

std::string refusal_of_text(const std::string& text) {
  try {
    (void)parse_problem(text, "p.json");
  } catch (const config::ConfigError& error) {
    return error.what();
  }
  return "no error";
}

using Change = std::function<void(Json&)>;

std::string refusal(const Change& change, Json json = problem()) {
  change(json);
  return refusal_of_text(json.dump());
}

/// A value in the place of another one.
Change set(const std::string& pointer, Json value) {
  return [=](Json& json) { json[Json::json_pointer(pointer)] = value; };
}

Change erase(const std::string& parent, const std::string& key) {
  return [=](Json& json) { json[Json::json_pointer(parent)].erase(key); };
}

const c3::Solution& solve(const ProblemFile& p, c3::Solver& solver) {
  solver.set_costs(p.costs, p.constraints);
  return p.lcs.size() == 1 ? solver.solve(p.lcs.front(), p.x0, p.x_desired)
                           : solver.solve(p.lcs, p.x0, p.x_desired);
}

}  // namespace

TEST_CASE("problem file: what it says is what is read") {
  const ProblemFile p = read(problem());
  CHECK(p.sizes.n_x == 1);
  CHECK(p.sizes.n_lambda == 1);
  CHECK(p.sizes.n_u == 1);
  CHECK(p.sizes.N == 3);
  CHECK(p.lcs.size() == 1);
  CHECK(p.lcs[0].c[0] == -0.2);
  CHECK(p.costs.Q_N(0, 0) == 2.0);
  CHECK(p.costs.U(0, 0) == 9.0);
  CHECK(p.settings.admm_iterations == 4);
  CHECK(p.settings.rho == 0.1);
  CHECK(p.settings.rho_scale == 2.0);
  CHECK(p.settings.projection == c3::ProjectionKind::kMiqp);
  CHECK(p.settings.qp == c3::QpBackend::kDirect);
  CHECK_FALSE(p.settings.trace);
  CHECK_FALSE(p.settings.fix_lambda_0);
  CHECK_FALSE(p.settings.delta_starts_at_x0);
  CHECK(p.method == config::Method::kC3);
  CHECK_FALSE(p.deadline_s);
  CHECK(p.threads == 1);
  CHECK(p.x_desired == Eigen::MatrixXd::Zero(1, 4));
}

TEST_CASE("problem file: optional keys are read") {
  Json json = problem();
  json.update({{"trace", true}, {"deadline_s", 0.25}, {"threads", 3}, {"seed", 7}, {"qp", "osqp"}});
  json["params"].update({{"delta0", "x0"}, {"fix_lambda0", true}, {"M", 50}});
  json["params"]["xd"] = {{0.0}, {1.0}, {2.0}, {3.0}};
  const ProblemFile p = read(json);
  CHECK(p.settings.trace);
  CHECK(p.deadline_s == 0.25);
  CHECK(p.threads == 3);
  CHECK(p.settings.qp == c3::QpBackend::kOsqp);
  CHECK(p.settings.delta_starts_at_x0);
  CHECK(p.settings.fix_lambda_0);
  CHECK(p.big_M == 50.0);
  CHECK(p.x_desired == Eigen::RowVector4d(0, 1, 2, 3));
  json["deadline_s"] = nullptr;
  json["params"]["delta0"] = "zero";
  CHECK_FALSE(read(json).deadline_s);
  CHECK_FALSE(read(json).settings.delta_starts_at_x0);
}

TEST_CASE("problem file: matrices and systems may be given per stage") {
  Json json = problem();
  const Json first = json["lcs"];
  Json second = first;
  second["A"] = {{0.9}};
  json["lcs"] = {first, second, first};
  json["params"]["Q"] = {{{1.0}}, {{2.0}}, {{3.0}}};
  const ProblemFile p = read(json);
  REQUIRE(p.lcs.size() == 3);
  CHECK(p.lcs[1].A(0, 0) == 0.9);
  CHECK(p.costs.Q[2](0, 0) == 3.0);
}

TEST_CASE("problem file: bounds are one list or one a stage, null is none") {
  Json json = problem();
  json["params"].update({{"xmin", {nullptr}}, {"xmax", nullptr}});
  CHECK(read(json).settings.qp == c3::QpBackend::kDirect);  // there is no bound after all

  json["params"].update({{"xmin", {-1}}, {"umax", {{0.5}, {nullptr}, {0.25}}}});
  const ProblemFile p = read(json);
  CHECK(p.constraints.x_min[2][0] == -1.0);
  CHECK(p.constraints.x_N_min.size() == 0);  // as the published code has it
  REQUIRE(p.constraints.u_max.count() == 3);
  CHECK(p.constraints.u_max[0][0] == 0.5);
  CHECK(p.constraints.u_max[1][0] == kInfinity);
  CHECK(p.settings.qp == c3::QpBackend::kInteriorPoint);

  // states: without k = 0, or with the last one
  json["params"]["xmin"] = {{-1}, {-2}};
  CHECK(read(json).constraints.x_min[2][0] == -2.0);
  json["params"]["xmin"] = {{nullptr}, {-1}, {-2}, {-3}};
  CHECK(read(json).constraints.x_min[2][0] == -2.0);
  CHECK(read(json).constraints.x_N_min[0] == -3.0);
}

TEST_CASE("problem file: rows C z and lambda have bounds, one list or one a stage, null is none") {
  Json json = problem();
  json["params"].update({{"lambdamin", {0}}, {"lambdamax", {{1}, {nullptr}, {2}}}});
  ProblemFile p = read(json);
  CHECK(p.constraints.lambda_min[2][0] == 0.0);
  REQUIRE(p.constraints.lambda_max.count() == 3);
  CHECK(p.constraints.lambda_max[1][0] == kInfinity);
  CHECK(p.settings.qp == c3::QpBackend::kInteriorPoint);

  json = problem();
  json["params"].update(
      {{"C", {{1, 0, 2}, {0, 1, 0}}}, {"Cmin", {-1, nullptr}}, {"Cmax", {nullptr, 3}}});
  p = read(json);
  CHECK(p.constraints.C[2] == (Eigen::MatrixXd(2, 3) << 1, 0, 2, 0, 1, 0).finished());
  CHECK(p.constraints.C_min[0] == Eigen::Vector2d(-1, -kInfinity));
  CHECK(p.constraints.C_max[0] == Eigen::Vector2d(kInfinity, 3));

  json["params"].erase("Cmin");
  CHECK(read(json).constraints.C_min[2] == Eigen::Vector2d(-kInfinity, -kInfinity));

  // as many rows as each stage has, none too
  json["params"].update({{"C", Json::parse("[[[1, 0, 2]], [], [[0, 1, 0], [0, 0, 1]]]")},
                         {"Cmin", Json::parse("[[0], [], [1, null]]")},
                         {"Cmax", nullptr}});
  p = read(json);
  REQUIRE(p.constraints.C.count() == 3);
  CHECK(p.constraints.C[1].rows() == 0);
  CHECK(p.constraints.C_min[2] == Eigen::Vector2d(1, -kInfinity));
  for (const char* none : {"[]", "[[], [], []]"}) {
    json["params"].update({{"C", Json::parse(none)}, {"Cmin", nullptr}});
    CHECK_FALSE(c3::any(read(json).constraints));
  }

  const std::vector<std::pair<Json, std::string>> refused{
      {{{"Cmin", {0}}}, "C: expected a value, got none"},
      {{{"C", {{1, 0}}}, {"Cmin", {0}}}, "C: expected 1 x 3, got 1 x 2"},
      {{{"C", {{1, 0, 0}}}, {"Cmin", {0, 0}}}, "Cmin: expected 1 values, got 2"},
      {{{"C", {{1, 0, 0}}}, {"Cmin", {1}}, {"Cmax", {0}}},
       "Cmin[0]: expected at most params.Cmax = 0, got 1"},
      {{{"C", Json::parse("[[[1, 0, 2]], []]")}}, "C: expected one matrix or N = 3, got 2"},
      {{{"C", Json::parse("[[[1, 0, 2]], [], []]")}, {"Cmin", {0}}},
       "Cmin: expected one list or N = 3, got 1"},
      {{{"C", {{1, 0, "x"}}}}, "C[0][2]: expected a number, got \"x\""},
      {{{"lambdamin", {0, 0}}}, "lambdamin: expected 1 values, got 2"},
      {{{"lambdamin", {1}}, {"lambdamax", {0}}},
       "lambdamin[0]: expected at most params.lambdamax = 0, got 1"}};
  for (const auto& [more, message] : refused) {
    CHECK_THAT(refusal([&more = more](Json& changed) { changed["params"].update(more); }),
               Equals("p.json: params." + message));
  }
}

TEST_CASE("problem file: a row C z binds like the bound that it stands for") {
  const auto u_and_lambda = [](const Json& more) {
    Json json = problem();
    json["params"].update(more);
    const ProblemFile p = read(json);
    c3::Solver solver(p.sizes, p.settings);
    const c3::Solution& solution = solve(p, solver);
    REQUIRE(solution.status == c3::SolveStatus::kOk);
    return Eigen::MatrixXd(solution.z.bottomRows(2));
  };
  const Eigen::MatrixXd free = u_and_lambda(Json::object());
  const double u = 0.5 * free(1, 0), lambda = 0.5 * free.row(0).maxCoeff();
  const Json u_row{{"C", {{0, 0, 1}}}}, lambda_row{{"C", {{0, 1, 0}}}};
  Json bound, row = u_row;
  REQUIRE(u < 0.0);
  bound["umin"] = {u};
  row["Cmin"] = {u};
  CHECK((u_and_lambda(bound) - u_and_lambda(row)).norm() < 1e-8);
  CHECK(u_and_lambda(row).row(1).minCoeff() == Approx(u));
  row = lambda_row;
  bound = {{"lambdamax", {lambda}}};
  row["Cmax"] = {lambda};
  CHECK((u_and_lambda(bound) - u_and_lambda(row)).norm() < 1e-8);
  CHECK(u_and_lambda(row).row(0).maxCoeff() == Approx(lambda));
}

namespace {

/// The same without contacts or without inputs; an m × 0 matrix as m empty rows, or as [].
Json without(bool contacts, bool inputs, bool rows) {
  Json json = problem();
  const Json no_columns = rows ? Json::parse("[[]]") : Json::array(), none = Json::array();
  Json& lcs = json["lcs"];
  Json& params = json["params"];
  if (!contacts)
    lcs.update({{"D", no_columns}, {"E", none}, {"F", none}, {"H", none}, {"c", none}});
  if (!inputs) {
    lcs["B"] = no_columns;
    lcs["H"] = contacts ? no_columns : none;
    params["R"] = none;
  }
  const int n_z = 1 + (contacts ? 1 : 0) + (inputs ? 1 : 0);
  Json weight = Json::array();
  for (int i = 0; i < n_z; ++i) {
    weight.push_back(Json::array());
    for (int j = 0; j < n_z; ++j) weight[i].push_back(i == j ? 1 : 0);
  }
  params.update({{"G", weight}, {"U", weight}});
  return json;
}

}  // namespace

TEST_CASE("problem file: without contacts or inputs the empty blocks are [] or empty rows") {
  for (const bool contacts : {false, true}) {
    for (const bool inputs : {false, true}) {
      for (const bool rows : {false, true}) {
        const ProblemFile p = read(without(contacts, inputs, rows));
        CAPTURE(contacts, inputs, rows);
        CHECK(p.sizes.n_lambda == (contacts ? 1 : 0));
        CHECK(p.sizes.n_u == (inputs ? 1 : 0));
        CHECK(p.lcs[0].D.rows() == 1);
        CHECK(p.lcs[0].H.cols() == p.sizes.n_u);
        c3::Solver solver(p.sizes, p.settings);
        const c3::Solution& solution = solve(p, solver);
        const config::ProblemResult result = config::to_result(p, solution, 0.0);
        const Json written = Json::parse(config::to_json(p, result, solution.trace));
        CHECK(written["status"] == "ok");
        CHECK(written["lam"].size() == 3);
        CHECK(written["lam"][2].size() == (contacts ? 1 : 0));
        CHECK(written["u0"].size() == (inputs ? 1 : 0));

        // blocks that move nothing change nothing
        Json idle = problem();
        if (!contacts) idle["lcs"].update({{"D", {{0}}}, {"E", {{0}}}, {"c", {1}}});
        if (!inputs) idle["lcs"]["B"] = {{0}};
        const int n_z = p.sizes.n_z();
        for (const char* weight : {"G", "U"})
          idle["params"][weight] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        const ProblemFile same = read(idle);
        c3::Solver other(same.sizes, same.settings);
        const c3::Solution& expected = solve(same, other);
        REQUIRE(n_z == solution.z.rows());
        CHECK((solution.x_N - expected.x_N).norm() < 1e-9);
        CHECK((solution.z.topRows(1) - expected.z.topRows(1)).norm() < 1e-9);
        if (inputs) CHECK(solution.u_0()[0] == Approx(expected.u_0()[0]).margin(1e-9));
      }
    }
  }
}

TEST_CASE("problem file: of empty blocks the ones that are not say what was expected") {
  const Json none = Json::array();
  CHECK_THAT(refusal(set("/lcs/F", none)), Equals("p.json: lcs.F: expected 1 x 1, got 0 x 0"));
  CHECK_THAT(refusal(set("/lcs/B", none)), Equals("p.json: lcs.B: expected 1 x 1, got 0 x 0"));
  CHECK_THAT(refusal(set("/lcs/A", none)),
             Contains("p.json: lcs.A: expected a matrix, got an empty one"));
  CHECK_THAT(refusal(set("/params/R", {{1}}), without(true, false, true)),
             Equals("p.json: params.R: expected 0 x 0, got 1 x 1"));
  CHECK_THAT(refusal(set("/lcs/E", {{1}}), without(false, true, true)),
             Equals("p.json: lcs.D: expected 1 x 1, got 1 x 0"));
}

TEST_CASE("problem file: the weights of C3+ are a number or a list") {
  Json json = plus_problem();
  json["params"]["g_eta"] = {0.5};
  const ProblemFile p = read(json);
  CHECK(p.costs.plus.g_lambda == Eigen::VectorXd::Constant(1, 1.0));
  CHECK(p.costs.plus.g_eta == Eigen::VectorXd::Constant(1, 0.5));
  CHECK(p.costs.plus.u_lambda == Eigen::VectorXd::Constant(1, 3.0));
  CHECK_THAT(refusal(erase("/params", "u_eta"), plus_problem()),
             Equals("p.json: params.u_eta: expected a value, got none"));
  CHECK_THAT(refusal(set("/params/u_eta", Json::array({1, 2})), plus_problem()),
             Equals("p.json: params.u_eta: expected 1 values, got 2"));
  CHECK_THAT(refusal(set("/params/u_eta", 0), plus_problem()),
             Contains("params.u_eta[0]: expected a positive number, got 0"));
  CHECK_THAT(refusal(set("/params/g_eta", -1), plus_problem()),
             Contains("params.g_eta[0]: expected a number of 0 or more, got -1"));
  CHECK(p.costs.plus.final_scale.size() == 0);
  json["params"]["final_scale"] = 100;
  CHECK(read(json).costs.plus.final_scale == Eigen::VectorXd::Constant(1, 100.0));
  CHECK_THAT(refusal(set("/params/final_scale", 0.5), plus_problem()),
             Contains("params.final_scale[0]: expected a number of 1 or more, got 0.5"));
}

TEST_CASE("problem file: a refusal names the key, what was expected and what came") {
  const std::vector<std::pair<Change, std::string>> refused{
      // missing, unknown, of the wrong kind
      {erase("", "x0"), "x0: expected a value, got none"},
      {erase("", "lcs"), "lcs: expected a value, got none"},
      {erase("", "params"), "params: expected a value, got none"},
      {erase("", "schema"), "schema: expected a value, got none"},
      {erase("", "projection"), "projection: expected a value, got none"},
      {erase("/params", "G"), "params.G: expected a value, got none"},
      {erase("/params", "U"), "params.U: expected a value, got none"},
      {erase("/params", "N"), "params.N: expected a value, got none"},
      {erase("/params", "QN"), "params.QN: expected a value, got none"},
      {erase("/lcs", "c"), "lcs.c: expected a value, got none"},
      {set("/rho", 1), "rho: unknown key"},
      {set("/params/rhos", 1), "params.rhos: unknown key"},
      {set("/lcs/G", 1), "lcs.G: unknown key"},
      {set("/schema", "c3-problem-2"),
       "schema: expected one of c3-problem-1, got \"c3-problem-2\""},
      {set("/projection", "QP"),
       "projection: expected one of MIQP, LCP, ADMM, CONVEX, C3+, got \"QP\""},
      {set("/method", "MIQP"), "method: expected one of C3, MIQP15, got \"MIQP\""},
      {set("/qp", 3), "qp: expected one of auto, osqp, direct, got 3"},
      {set("/trace", 1), "trace: expected true or false, got 1"},
      {set("/params", Json::array({1})), "params: expected an object, got a list"},
      {set("/lcs", 5), "lcs: expected an object, got 5"},
      {set("/x0", 0.5), "x0: expected a list of 1 numbers, got 0.5"},
      {set("/params/delta0", "x1"), "params.delta0: expected one of zero, x0, got \"x1\""},
      {set("/params/fix_lambda0", "yes"),
       "params.fix_lambda0: expected true or false, got \"yes\""},
      // numbers out of range
      {set("/params/N", 0), "params.N: expected an integer in [1, 1000], got 0"},
      {set("/params/N", 2.5), "params.N: expected an integer in [1, 1000], got 2.5"},
      {set("/params/N", 1e12), "params.N: expected an integer in [1, 1000]"},
      {set("/params/s", 0), "params.s: expected an integer in [1, 100000], got 0"},
      {set("/params/rho", -1), "params.rho: expected a number in [0, inf], got -1"},
      {set("/params/rho", 0), "params.rho: expected a positive number, got 0"},
      {set("/params/rho_s", 0), "params.rho_s: expected a positive number, got 0"},
      {set("/params/M", -1), "params.M: expected a number in [0, inf], got -1"},
      {set("/threads", 0), "threads: expected an integer in [1, 256], got 0"},
      {set("/seed", -1), "seed: expected an integer in [0, 2147483647], got -1"},
      {set("/deadline_s", -0.1), "deadline_s: expected a number in [0, inf], got -0.1"},
      {set("/deadline_s", "soon"), "deadline_s: expected a number, got \"soon\""},
      // sizes
      {set("/x0", Json::array({1, 2})), "x0: expected 1 values, got 2"},
      {set("/lcs/A", {{1, 2}}), "lcs.A: expected 1 x 1, got 1 x 2"},
      {set("/lcs/B", {{1}, {2}}), "lcs.B: expected 1 x 1, got 2 x 1"},
      {set("/lcs/D", {{1, 2}}), "lcs.D: expected 1 x 1, got 1 x 2"},
      {set("/lcs/d", Json::array()), "lcs.d: expected 1 values, got 0"},
      {set("/lcs/H", {{1, 2}}), "lcs.H: expected 1 x 1, got 1 x 2"},
      {set("/params/G", {{1}}), "params.G: expected 3 x 3, got 1 x 1"},
      {set("/params/U", {{1, 0, 0}, {0, 1}, {0, 0, 1}}),
       "params.U: expected rows of one length, got several"},
      {set("/params/Q", {{{1}}, {{1}}}), "params.Q: expected one matrix or N = 3, got 2"},
      {set("/params/xd", Json::array({0, 0})), "params.xd: expected 1 values, got 2"},
      {set("/params/xd", {{0}, {0}}), "params.xd: expected 4 x 1, got 2 x 1"},
      {[](Json& json) {
         json["lcs"] = {json["lcs"], json["lcs"]};
       },
       "lcs: expected one system or a list of N = 3, got a list of 2"},
      {[](Json& json) {
         Json wider = json["lcs"];
         wider.update({{"E", {{1}, {1}}},
                       {"F", {{1, 0}, {0, 1}}},
                       {"H", {{0}, {0}}},
                       {"D", {{1, 1}}},
                       {"c", {0, 0}}});
         json["lcs"] = {json["lcs"], wider, json["lcs"]};
       },
       "lcs[1]: expected the sizes of lcs[0], got others"},
      // no numbers
      {set("/lcs/F", {{nullptr}}), "lcs.F[0][0]: expected a number, got null"},
      {set("/params/QN", {{"1"}}), "params.QN[0][0]: expected a number, got \"1\""},
      {set("/x0", Json::array({true})), "x0[0]: expected a number, got true"},
      // not convex
      {set("/params/Q", {{-1}}),
       "params.Q: expected a positive semidefinite matrix, got the eigenvalue -1"},
      {set("/params/R", {{-1}}),
       "params.R: expected a positive semidefinite matrix, got the eigenvalue -1"},
      {set("/params/QN", {{-2}}),
       "params.QN: expected a positive semidefinite matrix, got the eigenvalue -2"},
      {set("/params/G", {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}),
       "params.G: expected a positive semidefinite matrix, got the eigenvalue -1"},
      {set("/params/G", {{1, 0, 0}, {0, 0, 0}, {0, 0, 1}}),
       "params.G: expected a positive definite weight of lambda"},
      {set("/params/U", {{1, 2, 0}, {2, 1, 0}, {0, 0, 1}}),
       "params.U: expected a positive semidefinite matrix, got the eigenvalue -1"},
      {set("/params/U", {{1, 2, 0}, {0, 1, 0}, {0, 0, 1}}),
       "params.U: expected a symmetric matrix"},
      {set("/params/Q", {{{1}}, {{-3}}, {{1}}}),
       "params.Q[1]: expected a positive semidefinite matrix, got the eigenvalue -3"},
      // bounds
      {set("/params/xmin", Json::array({1, 2})), "params.xmin: expected 1 values, got 2"},
      {set("/params/umax", 1), "params.umax: expected a list of 1 numbers or null, got 1"},
      {set("/params/umin", {{0}, {0}}), "params.umin: expected one list or N = 3, got 2"},
      {set("/params/umin", Json::array({"low"})), "params.umin[0]: expected a number, got \"low\""},
      {[](Json& json) {
         json["params"].update({{"umin", {1}}, {"umax", {-1}}});
       },
       "params.umin[0]: expected at most params.umax = -1, got 1"},
      // fix_lambda0 needs an LCP at x0 that u does not enter
      {[](Json& json) {
         json["params"]["fix_lambda0"] = true;
         json["lcs"]["H"] = {{0.5}};
       },
       "params.fix_lambda0: expected false where lcs.H is not zero"},
  };
  for (const auto& [change, message] : refused) {
    CHECK_THAT(refusal(change), Contains("p.json: " + message));
  }
}

TEST_CASE("problem file: the convex projection's weights are refused by their keys") {
  CHECK(refusal([](Json&) {}, convex_problem()) == "no error");
  CHECK_THAT(refusal(erase("/params", "Qx"), convex_problem()),
             Equals("p.json: params.Qx: expected a value, got none"));
  CHECK_THAT(refusal(set("/params/Qu", {{0}}), convex_problem()),
             Contains("params.Qu: expected a positive definite matrix, got the eigenvalue 0"));
  CHECK_THAT(refusal(set("/params/alpha", 1.5), convex_problem()),
             Equals("p.json: params.alpha: expected a number in [0, 1], got 1.5"));
  CHECK_THAT(refusal(set("/params/eps", -1), convex_problem()),
             Equals("p.json: params.eps: expected a number in [0, inf], got -1"));
}

TEST_CASE("problem file: what is no JSON, has a key twice or holds NaN is refused with its place") {
  const std::string text = problem().dump();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from);
    REQUIRE(at != std::string::npos);
    return changed.replace(at, from.size(), to);
  };
  CHECK_THAT(refusal_of_text(text.substr(0, 100)),
             Contains("p.json: expected JSON: parse error at"));
  CHECK_THAT(refusal_of_text(""), Contains("p.json: expected JSON:"));
  CHECK_THAT(refusal_of_text("[]"), Contains("expected an object, got a list"));
  CHECK_THAT(refusal_of_text(with("\"N\":3", "\"N\":3,\"N\":4")),
             Equals("p.json: N: expected each key once, got it twice"));
  CHECK_THAT(refusal_of_text(with("\"x0\":[0.5]", "\"x0\":[NaN]")),
             Equals("p.json: x0[0]: expected a number, got \"NaN\""));
  CHECK_THAT(refusal_of_text(with("[[1.1]]", "[[-Infinity]]")),
             Equals("p.json: lcs.A[0][0]: expected a number, got \"-Infinity\""));
  CHECK_THAT(refusal_of_text(with("[[1.1]]", "[[1e400]]")), Contains("p.json: expected JSON:"));
  CHECK_THAT(refusal_of_text(std::string(100000, '[')), Contains("p.json: expected JSON:"));
}

TEST_CASE("problem file: a file that cannot be read is named") {
  CHECK_THROWS_WITH(config::load_problem("/nowhere/p.json"),
                    Equals("/nowhere/p.json: expected a file that can be read, got No such file or "
                           "directory"));
}

TEST_CASE("problem file: a folder, an empty file and one without an end are named") {
  CHECK_THROWS_WITH(config::load_problem("/tmp"),
                    Equals("/tmp: expected a problem file, got a folder"));
  CHECK_THROWS_WITH(config::load_problem("/dev/null"),
                    Equals("/dev/null: expected a problem, got an empty file"));
  CHECK_THROWS_WITH(config::load_problem("/dev/zero"),
                    Equals("/dev/zero: expected at most 268435456 bytes, got more"));
}

TEST_CASE("problem file: a trace beyond all memory is refused") {
  CHECK_THAT(refusal([](Json& json) {
               json["trace"] = true;
               json["params"]["s"] = 100000;
               json["params"]["N"] = 1000;
             }),
             Equals("p.json: trace: expected false for s and N as large as these, got true"));
}

TEST_CASE("problem file: a result has exactly the keys of its schema") {
  Json json = problem();
  for (const bool trace : {false, true}) {
    json["trace"] = trace;
    const ProblemFile p = read(json);
    c3::Solver solver(p.sizes, p.settings);
    const c3::Solution& solution = solve(p, solver);
    const Json result =
        Json::parse(to_json(p, config::to_result(p, solution, 0.125), solution.trace));
    std::vector<std::string> keys{"complementarity_violation",
                                  "iterations",
                                  "lam",
                                  "objective",
                                  "qp_dual_residual",
                                  "qp_primal_residual",
                                  "schema",
                                  "solve_time_s",
                                  "status",
                                  "u",
                                  "u0",
                                  "x"};
    if (trace) keys.insert(keys.begin() + 2, "iters");
    std::vector<std::string> found;
    for (const auto& item : result.items()) found.push_back(item.key());
    CHECK(found == keys);
    CHECK(result["schema"] == "c3-result-1");
    CHECK(result["status"] == "ok");
    CHECK(result["iterations"] == 4);
    CHECK(result["solve_time_s"] == 0.125);
    CHECK(result["x"].size() == 4);
    CHECK(result["lam"].size() == 3);
    CHECK(result["u"].size() == 3);
    CHECK(result["u0"] == result["u"][0]);
    CHECK(result["x"][0] == json["x0"]);
    if (!trace) continue;
    REQUIRE(result["iters"].size() == 4);
    CHECK(result["iters"][1]["rho"] == 0.2);
    for (const char* key : {"z", "delta", "w", "proj"}) CHECK(result["iters"][3][key].size() == 3);
    CHECK(result["iters"][3]["xN"] == result["x"][3]);
  }
}

TEST_CASE("problem file: of a failed solve the result has the last QP and the turns before it") {
  Json json = problem();
  json["trace"] = true;
  json["lcs"]["E"] = {{0}};
  json["lcs"]["F"] = {{0}};  // 0 ≤ λ ⊥ −0.2 ≥ 0: no point
  const ProblemFile p = read(json);
  c3::Solver solver(p.sizes, p.settings);
  solver.set_costs(p.costs, p.constraints);
  const c3::Solution& solution = solver.solve(p.lcs.front(), p.x0, p.x_desired);
  const Json result =
      Json::parse(config::to_json(p, config::to_result(p, solution, 0.0), solution.trace));
  CHECK(result["status"] == "fail: stage 0: the set that the projection is onto is empty");
  CHECK(result["iterations"] == 1);
  CHECK(result["iters"].empty());
  CHECK(result["u0"][0].get<double>() != 0.0);
}

TEST_CASE("problem file: each way in which a projection has no point has its own words and stage") {
  const auto status = [](const Json& json) {
    const ProblemFile p = read(json);
    c3::Solver solver(p.sizes, p.settings);
    return config::to_result(p, solve(p, solver), 0.0).status;
  };
  // the third stage's F alone is not positive semidefinite
  Json convex = convex_problem();
  convex["lcs"] = Json::array({convex["lcs"], convex["lcs"], convex["lcs"]});
  CHECK(status(convex) == "ok");
  convex["lcs"][2]["F"] = {{-1}};
  CHECK(status(convex) ==
        "fail: stage 2: the convex projection needs F + eps I positive semidefinite, its smallest "
        "eigenvalue is -0.99");
  convex["params"]["eps"] = 1.5;
  CHECK(status(convex) == "ok");

  Json empty = problem();
  empty["lcs"].update({{"E", {{0}}}, {"F", {{0}}}});  // y = −0.2
  for (const auto& [projection, words] : std::vector<std::pair<std::string, std::string>>{
           {"MIQP", "the set that the projection is onto is empty"},
           {"ADMM", "the set that the projection is onto is empty: no x, u and lambda >= 0 have"},
           {"LCP", "Lemke's method finds no solution of the LCP"}}) {
    empty["projection"] = projection;
    CHECK_THAT(status(empty), Contains("fail: stage 0: " + words));
  }

  // max_nodes: the first QP of the search is not in the set, and there is no second
  Json short_search = problem();
  short_search["params"]["max_nodes"] = 1;
  short_search["x0"] = {-5};
  CHECK(status(short_search) ==
        "fail: stage 0: the projection's search ended at max_nodes = 1 before it found a point");
  short_search["params"].erase("max_nodes");
  CHECK(status(short_search) == "ok");
}

TEST_CASE("problem file: golden cases written as problem files give the golden u_0") {
  int compared = 0;
  for (const char* example : {"cartpole", "finger", "pivoting"}) {
    Json golden;
    std::ifstream(std::string(C3RT_SOURCE_DIRECTORY "/tests/data/golden/") + example + ".json") >>
        golden;
    for (const Json& one : golden["cases"]) {
      // where the projections have one minimiser
      const Json& margin = one["quality"]["miqp_min_margin"];
      bool unique = one["status"] == "ok" && (margin.is_null() || margin > 1e-3);
      for (const Json& iteration : one["iters"]) {
        for (const Json& projection : iteration["proj"]) {
          unique = unique && (one["projection"] != "LCP" || (projection["n_isolated"] == 1 &&
                                                             projection["n_singular_sets"] == 0));
        }
      }
      if (!unique) continue;
      const ProblemFile p =
          read({{"schema", "c3-problem-1"},
                {"lcs", one["lcs"] == "const" ? golden["lcs_const"] : one["lcs"]},
                {"params", golden["param_sets"][one["param_set"].get<std::string>()]},
                {"projection", one["projection"]},
                {"x0", one["x0"]}});
      c3::Solver solver(p.sizes, p.settings);
      const c3::Solution& solution = solve(p, solver);
      INFO(one["id"].get<std::string>());
      REQUIRE(solution.status == c3::SolveStatus::kOk);
      const std::vector<double> values = one["u0"];
      const Eigen::Map<const Eigen::VectorXd> expected(values.data(),
                                                       static_cast<Eigen::Index>(values.size()));
      CHECK((solution.u_0() - expected).norm() <= 1e-5 * std::max(1.0, expected.norm()));
      ++compared;
    }
  }
  CHECK(compared >= 30);
}
