#pragma once

#include <string>
#include <vector>

#include "controller/horizon/problem.hpp"
#include "tests/controller/c3/golden.hpp"

/// Recorded optima of the monolithic problem [C3, eq. (15)] by independent reference code (schema
/// c3-miqp15-1), see tests/data/golden.
namespace golden15 {

struct Case {
  std::string name;  // example, state and horizon
  c3rt::lcs::Lcs lcs;
  c3rt::c3::Costs costs;
  c3rt::c3::Constraints constraints;
  Eigen::VectorXd x0;
  Eigen::VectorXd x_desired;
  int N = 0;
  double big_m = 0.0;
  double objective = 0.0;  // of the reference's branch and bound, which knows no M

  /// Refers to this case.
  c3rt::horizon::Problem problem() const {
    const auto n = c3rt::lcs::sizes(lcs);
    return {{n.n_x, n.n_lambda, n.n_u, N}, {&lcs, 0}, &costs, &constraints,
            x_desired.replicate(1, N + 1), x0};
  }
};

inline std::vector<Case> load() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::ifstream file(C3RT_SOURCE_DIRECTORY "/tests/data/golden/miqp15.json");
  if (!file) throw std::runtime_error("cannot read tests/data/golden/miqp15.json");
  const golden::Json all = golden::Json::parse(file);
  std::vector<Case> cases;
  for (const golden::Json& json : all["cases"]) {
    const std::string example = json["example"];
    const golden::Json& p = all["params"][example];
    Case c;
    c.N = json["N"];
    c.name = example + " " + json["state_tag"].get<std::string>() + " N " + std::to_string(c.N);
    c.lcs = golden::lcs(json["lcs"].is_string() ? all["lcs_const"][example] : json["lcs"]);
    c.costs.Q = golden::matrix(p["Q"]);
    c.costs.R = golden::matrix(p["R"]);
    c.costs.Q_N = golden::matrix(p["QN"]);
    c.constraints.x_min = golden::vector(p["xmin"], -kInfinity);
    c.constraints.x_max = golden::vector(p["xmax"], kInfinity);
    c.constraints.u_min = golden::vector(p["umin"], -kInfinity);
    c.constraints.u_max = golden::vector(p["umax"], kInfinity);
    c.x_desired = golden::vector(p["xd"]);
    c.x0 = golden::vector(json["x0"]);
    c.big_m = json["M"];
    c.objective = json["bnb"]["obj"];
    cases.push_back(std::move(c));
  }
  return cases;
}

}  // namespace golden15
