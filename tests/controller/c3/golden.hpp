#pragma once

#include <cstdlib>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "controller/c3/solver.hpp"

/// Recorded C3 calls of independent reference code (schema c3-golden-1), see tests/data/golden.
namespace golden {

using Json = nlohmann::json;

inline Eigen::VectorXd vector(const Json& json, double null = 0.0) {
  Eigen::VectorXd v(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    v[i] = json[i].is_null() ? null : json[i].get<double>();
  }
  return v;
}

inline Eigen::MatrixXd matrix(const Json& json) {
  Eigen::MatrixXd m(json.size(), json.empty() ? 0 : json[0].size());
  for (std::size_t i = 0; i < json.size(); ++i) m.row(i) = vector(json[i]).transpose();
  return m;
}

struct Iteration {
  double rho;
  Eigen::MatrixXd z, delta;  // (n_z × N)
  Eigen::VectorXd x_N;
  Eigen::VectorXd objective, margin;  // of the projections; margin: infinite where no other mode is
  bool unique_lambda;                 // of all LCP projections
};

struct Case {
  std::string id, parameters, projection;
  c3rt::c3::Sizes sizes;
  c3rt::lcs::Lcs lcs;
  c3rt::c3::Costs costs;
  c3rt::c3::Constraints bounds;
  int s;
  double rho, rho_scale;
  bool delta_starts_at_x0, fixes_lambda_0, bounded;
  Eigen::VectorXd x0, u_0;
  Eigen::MatrixXd x_desired;
  std::vector<Iteration> iterations;

  c3rt::c3::ProjectionKind kind() const {
    if (projection == "LCP") return c3rt::c3::ProjectionKind::kLcp;
    if (projection == "CONVEX") return c3rt::c3::ProjectionKind::kConvex;
    return c3rt::c3::ProjectionKind::kMiqp;
  }

  c3rt::c3::Settings settings(c3rt::c3::QpBackend qp) const {
    c3rt::c3::Settings made{s,      rho,     rho_scale,         qp, {20000, 1e-10, 0.1, 50, true},
                            kind(), 1 << 12, delta_starts_at_x0};
    made.project_last = true;  // as the reference does
    made.fix_lambda_0 = fixes_lambda_0;
    made.trace = true;
    return made;
  }
};

inline c3rt::lcs::Lcs lcs(const Json& json) {
  return {matrix(json["A"]), matrix(json["B"]), matrix(json["D"]), vector(json["d"]),
          matrix(json["E"]), matrix(json["F"]), matrix(json["H"]), vector(json["c"])};
}

inline std::vector<Case> load(const std::string& example) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  // another folder of the same kind may be named, to run more cases than the few kept here
  const char* elsewhere = std::getenv("C3RT_GOLDEN");
  const std::string folder =
      elsewhere != nullptr ? elsewhere : C3RT_SOURCE_DIRECTORY "/tests/data/golden";
  std::ifstream file(folder + "/" + example + ".json");
  if (!file) throw std::runtime_error("cannot read " + folder + "/" + example + ".json");
  const Json all = Json::parse(file);
  std::vector<Case> cases;
  for (const Json& json : all["cases"]) {
    const Json& p = all["param_sets"][json["param_set"].get<std::string>()];
    Case c;
    c.id = json["id"];
    c.parameters = json["param_set"];
    c.projection = json["projection"];
    c.lcs = lcs(json["lcs"].is_string() ? all["lcs_const"] : json["lcs"]);
    const auto [n_x, n_lambda, n_u] = c3rt::lcs::sizes(c.lcs);
    c.sizes = {n_x, n_lambda, n_u, p["N"].get<int>()};
    c.costs = {matrix(p["Q"]), matrix(p["QN"]), matrix(p["R"]), matrix(p["G"]), matrix(p["U"])};
    if (c.projection == "CONVEX") {
      c.costs.convex = {matrix(p["Qx"]), matrix(p["Qu"]), p["alpha"], p["eps"]};
    }
    c.bounds.x_min = vector(p["xmin"], -kInfinity);
    c.bounds.x_max = vector(p["xmax"], kInfinity);
    c.bounds.u_min = vector(p["umin"], -kInfinity);
    c.bounds.u_max = vector(p["umax"], kInfinity);
    c.bounded = any(c.bounds);
    c.s = p["s"];
    c.rho = p["rho"];
    c.rho_scale = p["rho_s"];
    c.delta_starts_at_x0 = p["delta0"] == "x0";
    c.fixes_lambda_0 = p["fix_lambda0"];
    c.x0 = vector(json["x0"]);
    c.u_0 = vector(json["u0"]);
    c.x_desired = vector(p["xd"]).replicate(1, c.sizes.N + 1);
    for (const Json& i : json["iters"]) {
      Iteration iteration;
      iteration.rho = i["rho"];
      iteration.z = matrix(i["z"]).transpose();
      iteration.delta = matrix(i["delta"]).transpose();
      iteration.x_N = vector(i["xN"]);
      iteration.objective = Eigen::VectorXd::Zero(c.sizes.N);
      iteration.margin = Eigen::VectorXd::Constant(c.sizes.N, kInfinity);
      iteration.unique_lambda = true;
      for (int k = 0; k < c.sizes.N; ++k) {
        const Json& projection = i["proj"][k];
        if (c.projection == "LCP") {
          iteration.unique_lambda = iteration.unique_lambda && projection["n_isolated"] == 1 &&
                                    projection["n_singular_sets"] == 0;
        } else if (c.projection == "MIQP") {
          iteration.objective[k] = projection["obj"];
          if (!projection["margin"].is_null()) iteration.margin[k] = projection["margin"];
        }
      }
      c.iterations.push_back(iteration);
    }
    cases.push_back(c);
  }
  return cases;
}

}  // namespace golden
