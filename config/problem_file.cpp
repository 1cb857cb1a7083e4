#include "config/problem_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <utility>

#include "config/json_reader.hpp"
#include "config/read_file.hpp"

namespace c3rt::config {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// What a file may ask for before it is an attack on the memory.
constexpr int kMaxStages = 1000, kMaxIterations = 100000, kMaxThreads = 256;
constexpr double kMaxTraceNumbers = 1e8;
constexpr int kMaxNodes = 1 << 20;  // of one projection's branch and bound
constexpr std::size_t kMaxBytes = 1UL << 28;

Eigen::Index rows_of(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_array()
             ? static_cast<Eigen::Index>(json[key].size())
             : 0;
}

Eigen::Index cols_of(const Json& json, const char* key) {
  return rows_of(json, key) > 0 && json[key][0].is_array()
             ? static_cast<Eigen::Index>(json[key][0].size())
             : 0;
}

/// A, F and B say the sizes, the other blocks have to agree. Where F or B is empty, the other
/// blocks of its size say whether there are really no contacts or no inputs.
lcs::Lcs read_lcs(const Json& json, const std::string& name, const std::string& path) {
  JsonReader reader(json, name, path);
  const auto first_of = [](std::initializer_list<Eigen::Index> claims) {
    const auto* claim = std::find_if(claims.begin(), claims.end(), [](auto n) { return n > 0; });
    return claim == claims.end() ? 0 : *claim;
  };
  const Eigen::Index n_x = rows_of(json, "A");
  if (reader.at("A").empty()) {
    throw ConfigError(reader.place("A") + ": expected a matrix, got an empty one");
  }
  const Eigen::Index n_lambda =
      first_of({rows_of(json, "F"), rows_of(json, "E"), rows_of(json, "c"), cols_of(json, "D")});
  const Eigen::Index n_u = first_of({cols_of(json, "B"), cols_of(json, "H")});
  lcs::Lcs lcs;
  lcs.A = reader.matrix("A", n_x, n_x);
  lcs.B = reader.matrix("B", n_x, n_u);
  lcs.D = reader.matrix("D", n_x, n_lambda);
  lcs.d = reader.vector("d", n_x);
  lcs.E = reader.matrix("E", n_lambda, n_x);
  lcs.F = reader.matrix("F", n_lambda, n_lambda);
  lcs.H = reader.matrix("H", n_lambda, n_u);
  lcs.c = reader.vector("c", n_lambda);
  reader.finish();
  return lcs;
}

std::vector<lcs::Lcs> read_systems(const Json& json, const std::string& name, int N) {
  if (!json.is_array()) return {read_lcs(json, name, "lcs")};
  if (static_cast<int>(json.size()) != N) {
    throw ConfigError(name + ": lcs: expected one system or a list of N = " + std::to_string(N) +
                      ", got a list of " + std::to_string(json.size()));
  }
  std::vector<lcs::Lcs> all;
  for (int k = 0; k < N; ++k) {
    all.push_back(read_lcs(json[k], name, "lcs[" + std::to_string(k) + "]"));
    const lcs::Sizes first = lcs::sizes(all.front()), now = lcs::sizes(all.back());
    if (first.n_x != now.n_x || first.n_lambda != now.n_lambda || first.n_u != now.n_u) {
      throw ConfigError(name + ": lcs[" + std::to_string(k) +
                        "]: expected the sizes of lcs[0], got others");
    }
  }
  return all;
}

/// c3's checks name its own fields; the file's reader knows the file's keys.
std::string in_file_terms(std::string message) {
  std::vector<std::pair<std::string, std::string>> names;
  for (const auto type : c3::kProjectionTypes) {
    for (const c3::ProjectionWeight& weight : type().weights)
      names.emplace_back(std::string("Costs.") + type().key + "." + weight.key,
                         std::string("params.") + weight.problem_name);
  }
  static const std::pair<const char*, const char*> kNames[] = {
      {"Costs.Q_N", "params.QN"},
      {"Costs.", "params."},
      {"Constraints.x_N_min", "params.xmin"},
      {"Constraints.x_N_max", "params.xmax"},
      {"Constraints.x_min", "params.xmin"},
      {"Constraints.x_max", "params.xmax"},
      {"Constraints.u_min", "params.umin"},
      {"Constraints.u_max", "params.umax"},
      {"Constraints.lambda_min", "params.lambdamin"},
      {"Constraints.lambda_max", "params.lambdamax"},
      {"Constraints.C_min", "params.Cmin"},
      {"Constraints.C_max", "params.Cmax"},
      {"Settings.admm_iterations", "params.s"},
      {"Settings.rho_scale", "params.rho_s"},
      {"Settings.rho", "params.rho"},
  };
  names.insert(names.end(), std::begin(kNames), std::end(kNames));
  for (const auto& [ours, theirs] : names) {
    for (std::size_t at = message.find(ours); at != std::string::npos; at = message.find(ours)) {
      message.replace(at, ours.size(), theirs);
    }
  }
  return message;
}

void read_weight(JsonReader& params, const c3::ProjectionWeight& weight, ProblemFile& p) {
  using Shape = c3::ProjectionWeight::Shape;
  const char* name = weight.problem_name;
  switch (weight.shape) {
    case Shape::kOfStates:
      weight.matrix(p.costs) = params.matrix(name, p.sizes.n_x, p.sizes.n_x);
      break;
    case Shape::kOfInputs:
      weight.matrix(p.costs) = params.matrix(name, p.sizes.n_u, p.sizes.n_u);
      break;
    case Shape::kOfForces:
    case Shape::kOfGaps:
    case Shape::kOfContacts:
      weight.vector(p.costs) = params.numbers(name, p.sizes.n_lambda);
      break;
    case Shape::kNumber:
      weight.number(p.costs) = params.number(name, weight.minimum, weight.maximum);
      break;
  }
}

void read_costs(JsonReader& params, ProblemFile& p) {
  const auto [n_x, n_lambda, n_u, N] = p.sizes;
  const int n_z = p.sizes.n_z();
  p.costs.Q = params.matrices("Q", n_x, n_x, N);
  p.costs.Q_N = params.matrix("QN", n_x, n_x);
  p.costs.R = params.matrices("R", n_u, n_u, N);
  const bool c3 = p.method == Method::kC3;
  const c3::ProjectionKind kind = p.settings.projection;
  const c3::ProjectionType& type = c3::projection_type(kind);
  // a parameter set may hold what another projection needs
  if (params.has("G") || (c3 && type.needs_G)) p.costs.G = params.matrices("G", n_z, n_z, N);
  if (params.has("U") || (c3 && type.needs_U)) p.costs.U = params.matrix("U", n_z, n_z);
  for (const auto other : c3::kProjectionTypes) {
    for (const c3::ProjectionWeight& weight : other().weights) {
      const char* name = weight.problem_name;
      if (params.has(name) || (other().kind == kind && !weight.has_default))
        read_weight(params, weight, p);
    }
  }
}

void read_constraints(JsonReader& params, ProblemFile& p) {
  const auto [n_x, n_lambda, n_u, N] = p.sizes;
  const auto each = [stages = static_cast<std::size_t>(N)](Eigen::Index size) {
    return std::vector<Eigen::Index>(stages, size);
  };
  c3::Constraints& c = p.constraints;
  c.x_min = params.bounds("xmin", each(n_x), -kInfinity, true, &c.x_N_min);
  c.x_max = params.bounds("xmax", each(n_x), kInfinity, true, &c.x_N_max);
  c.lambda_min = params.bounds("lambdamin", each(n_lambda), -kInfinity);
  c.lambda_max = params.bounds("lambdamax", each(n_lambda), kInfinity);
  c.u_min = params.bounds("umin", each(n_u), -kInfinity);
  c.u_max = params.bounds("umax", each(n_u), kInfinity);
  if (!params.has("C") && !params.has("Cmin") && !params.has("Cmax")) return;
  c.C = params.matrices("C", JsonReader::kAnyRows, p.sizes.n_z(), N);
  std::vector<Eigen::Index> rows;
  for (int k = 0; k < N; ++k) rows.push_back(c.C[k].rows());
  // where one side has no bounds they are infinite, row by row
  const auto side = [&](const char* key, double none) -> c3::PerStage<VectorXd> {
    if (params.has(key) && !params.at(key).is_null()) return params.bounds(key, rows, none);
    std::vector<VectorXd> all;
    for (const Eigen::Index n : rows) all.emplace_back(VectorXd::Constant(n, none));
    return all;
  };
  c.C_min = side("Cmin", -kInfinity);
  c.C_max = side("Cmax", kInfinity);
}

MatrixXd read_desired(JsonReader& params, const c3::Sizes& sizes) {
  const Json& value = params.at("xd");
  const bool each = value.is_array() && !value.empty() && value[0].is_array();
  if (each) return params.matrix("xd", sizes.N + 1, sizes.n_x).transpose();
  return params.vector("xd", sizes.n_x).replicate(1, sizes.N + 1);
}

ProblemFile read(const Json& json, const std::string& name) {
  JsonReader top(json, name, "");
  top.choice("schema", {"c3-problem-1"});
  ProblemFile p{};
  p.method = top.choice("method", {"C3", "MIQP15"}, 0) == 0 ? Method::kC3 : Method::kMiqp15;
  std::vector<std::string> projections;
  for (const auto type : c3::kProjectionTypes) projections.emplace_back(type().problem_name);
  const std::size_t projection = p.method == Method::kC3 ? top.choice("projection", projections)
                                                         : top.choice("projection", projections, 0);
  p.settings.projection = c3::kProjectionTypes[projection]().kind;

  JsonReader params(top.at("params"), name, "params");
  const int N = params.integer("N", 1, kMaxStages);
  p.lcs = read_systems(top.at("lcs"), name, N);
  const lcs::Sizes of = lcs::sizes(p.lcs.front());
  p.sizes = {of.n_x, of.n_lambda, of.n_u, N};
  p.x0 = top.vector("x0", of.n_x);

  c3::Settings& settings = p.settings;
  const bool c3 = p.method == Method::kC3;
  settings.admm_iterations =
      c3 ? params.integer("s", 1, kMaxIterations) : params.integer("s", 1, kMaxIterations, 1);
  settings.rho =
      c3 ? params.number("rho", 0.0, kInfinity) : params.number("rho", 0.0, kInfinity, 1.0);
  settings.rho_scale = params.number("rho_s", 0.0, kInfinity, 1.0);
  settings.delta_starts_at_x0 = params.choice("delta0", {"zero", "x0"}, 0) == 1;
  settings.fix_lambda_0 = params.boolean("fix_lambda0", false);
  settings.max_nodes = params.integer("max_nodes", 1, kMaxNodes, kMaxNodes);
  settings.polish = params.integer("polish", 0, kMaxIterations, 0);
  settings.project_last = true;  // the result's last iterate is whole, as in the golden files
  settings.trace = top.boolean("trace", false);
  p.big_M = params.number("M", 0.0, kInfinity, 1000.0);
  p.x_desired = read_desired(params, p.sizes);
  read_costs(params, p);
  read_constraints(params, p);
  params.finish();

  settings.osqp = {20000, 1e-8, 0.1, 50, true};
  const bool osqp = top.choice("qp", {"auto", "osqp", "direct"}, 0) == 1;
  settings.qp = osqp                     ? c3::QpBackend::kOsqp
                : c3::any(p.constraints) ? c3::QpBackend::kInteriorPoint
                                         : c3::QpBackend::kDirect;
  if (top.has("deadline_s") && !top.at("deadline_s").is_null()) {
    p.deadline_s = top.number("deadline_s", 0.0, kInfinity);
  }
  p.threads = top.integer("threads", 1, kMaxThreads, 1);
  (void)top.integer("seed", 0, std::numeric_limits<int>::max(), 0);  // nothing here is random
  top.finish();

  const double trace_numbers =
      3.0 * settings.admm_iterations * N * (p.sizes.n_z() + p.sizes.n_lambda);
  if (settings.trace && trace_numbers > kMaxTraceNumbers) {
    throw ConfigError(name + ": trace: expected false for s and N as large as these, got true");
  }
  try {
    check(p.sizes);
    if (c3) {
      check(p.costs, p.sizes, settings.projection);
    } else {  // (15) knows neither G nor U
      c3::Costs horizon_costs = p.costs;
      horizon_costs.G = MatrixXd::Identity(p.sizes.n_z(), p.sizes.n_z());
      horizon_costs.U.resize(0, 0);
      check(horizon_costs, p.sizes, c3::ProjectionKind::kLcp);
    }
    check(p.constraints, p.sizes);
    check(p.settings);
  } catch (const std::invalid_argument& error) {
    throw ConfigError(name + ": " + in_file_terms(error.what()));
  }
  if (settings.fix_lambda_0 && !p.lcs.front().H.isZero(0.0)) {
    throw ConfigError(name +
                      ": params.fix_lambda0: expected false where lcs.H is not zero "
                      "(lambda_0 then depends on u_0), got true");
  }
  return p;
}

}  // namespace

ProblemFile parse_problem(const std::string& text, const std::string& name) {
  return read(parse_json(text, name), name);
}

ProblemFile load_problem(const std::string& path) {
  return parse_problem(read_file(path, "a problem", kMaxBytes), path);
}

}  // namespace c3rt::config
