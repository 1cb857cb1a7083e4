#include "config/problem_file.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

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

std::string shape(Eigen::Index rows, Eigen::Index cols) {
  return std::to_string(rows) + " x " + std::to_string(cols);
}

/// NaN and infinity are no JSON, but many programs write them: as strings they reach the check that
/// knows the key.
std::string quote_non_numbers(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      out += c;
      if (c == '\\' && i + 1 < text.size()) out += text[++i];
      in_string = c != '"';
      continue;
    }
    in_string = c == '"';
    bool quoted = false;
    for (const char* word : {"NaN", "-Infinity", "Infinity"}) {
      const std::size_t length = std::char_traits<char>::length(word);
      if (text.compare(i, length, word) != 0) continue;
      out += '"';
      out += word;
      out += '"';
      i += length - 1;
      quoted = true;
      break;
    }
    if (!quoted) out += c;
  }
  return out;
}

/// Reads values by key and refuses by key.
class Reader {
 public:
  Reader(const Json& json, std::string file, std::string path)
      : json_(json), file_(std::move(file)), path_(std::move(path)) {
    if (!json.is_object()) fail("", "an object", json);
  }

  bool has(const char* key) {
    used_.insert(key);
    return json_.contains(key);
  }

  const Json& at(const char* key) {
    used_.insert(key);
    const auto found = json_.find(key);
    if (found == json_.end()) throw ConfigError(place(key) + ": expected a value, got none");
    return *found;
  }

  double number(const char* key, double min, double max) {
    return as_number(key, at(key), min, max);
  }
  double number(const char* key, double min, double max, double missing) {
    return has(key) ? number(key, min, max) : missing;
  }

  int integer(const char* key, int min, int max) {
    const Json& value = at(key);
    if (!value.is_number_integer() || value.get<double>() < min || value.get<double>() > max) {
      fail(key, "an integer in [" + std::to_string(min) + ", " + std::to_string(max) + "]", value);
    }
    return value.get<int>();
  }
  int integer(const char* key, int min, int max, int missing) {
    return has(key) ? integer(key, min, max) : missing;
  }

  bool boolean(const char* key, bool missing) {
    if (!has(key)) return missing;
    if (!at(key).is_boolean()) fail(key, "true or false", at(key));
    return at(key).get<bool>();
  }

  /// The index of the value among the choices.
  std::size_t choice(const char* key, const std::vector<std::string>& choices) {
    const Json& value = at(key);
    std::string names;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      if (value.is_string() && value.get<std::string>() == choices[i]) return i;
      names += (i == 0 ? "" : ", ") + choices[i];
    }
    fail(key, "one of " + names, value);
  }
  std::size_t choice(const char* key, const std::vector<std::string>& choices,
                     std::size_t missing) {
    return has(key) ? choice(key, choices) : missing;
  }

  VectorXd vector(const char* key, Eigen::Index size) { return vector(key, at(key), size); }

  VectorXd vector(const std::string& key, const Json& value, Eigen::Index size) const {
    require_list(key, value, "a list of " + std::to_string(size) + " numbers");
    if (static_cast<Eigen::Index>(value.size()) != size) {
      throw ConfigError(place(key) + ": expected " + std::to_string(size) + " values, got " +
                        std::to_string(value.size()));
    }
    VectorXd out(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      out[i] = as_number(key + "[" + std::to_string(i) + "]", value[i], -kInfinity, kInfinity);
    }
    return out;
  }

  MatrixXd matrix(const char* key, Eigen::Index rows, Eigen::Index cols) {
    return matrix(key, at(key), rows, cols);
  }

  MatrixXd matrix(const std::string& key, const Json& value, Eigen::Index rows,
                  Eigen::Index cols) const {
    require_list(key, value, "a matrix " + shape(rows, cols) + ", a list of its rows");
    Eigen::Index widest = value.empty() ? 0 : -1;
    bool ragged = false;
    for (const Json& row : value) {
      require_list(key, row, "a matrix " + shape(rows, cols) + ", a list of its rows");
      const auto width = static_cast<Eigen::Index>(row.size());
      ragged |= widest >= 0 && width != widest;
      widest = std::max(widest, width);
    }
    if (ragged) throw ConfigError(place(key) + ": expected rows of one length, got several");
    if (static_cast<Eigen::Index>(value.size()) != rows || widest != cols) {
      // a matrix without rows cannot say how wide it is
      const bool both_empty = value.empty() && rows == 0;
      if (!both_empty) {
        throw ConfigError(place(key) + ": expected " + shape(rows, cols) + ", got " +
                          shape(static_cast<Eigen::Index>(value.size()), widest));
      }
    }
    MatrixXd out(rows, cols);
    for (Eigen::Index i = 0; i < rows; ++i) {
      for (Eigen::Index j = 0; j < cols; ++j) {
        out(i, j) = as_number(key + "[" + std::to_string(i) + "][" + std::to_string(j) + "]",
                              value[i][j], -kInfinity, kInfinity);
      }
    }
    return out;
  }

  /// A matrix for all stages, or a list of N.
  c3::PerStage<MatrixXd> matrices(const char* key, Eigen::Index rows, Eigen::Index cols, int N) {
    const Json& value = at(key);
    const bool each = value.is_array() && !value.empty() && value[0].is_array() &&
                      !value[0].empty() && value[0][0].is_array();
    if (!each) return matrix(key, rows, cols);
    if (static_cast<int>(value.size()) != N) {
      throw ConfigError(place(key) + ": expected one matrix or N = " + std::to_string(N) +
                        ", got " + std::to_string(value.size()));
    }
    std::vector<MatrixXd> all;
    for (int k = 0; k < N; ++k) {
      all.push_back(matrix(std::string(key) + "[" + std::to_string(k) + "]", value[k], rows, cols));
    }
    return all;
  }

  /// A list of numbers where null is no bound; empty if the key is missing or null.
  VectorXd bound(const std::string& key, const Json& value, Eigen::Index size, double none) const {
    require_list(key, value, "a list of " + std::to_string(size) + " numbers or null");
    if (static_cast<Eigen::Index>(value.size()) != size) {
      throw ConfigError(place(key) + ": expected " + std::to_string(size) + " values, got " +
                        std::to_string(value.size()));
    }
    VectorXd out(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const std::string name = key + "[" + std::to_string(i) + "]";
      if (value[i].is_null() ||
          (value[i].is_string() && (value[i] == "Infinity" || value[i] == "-Infinity"))) {
        const bool other_side = value[i].is_string() && (value[i] == "Infinity") != (none > 0.0);
        if (other_side) fail(name, "a number or null", value[i]);
        out[i] = none;
      } else {
        out[i] = as_number(name, value[i], -kInfinity, kInfinity);
      }
    }
    return out;
  }

  /// Bounds of a stage, or of each: lists of them for k = 0 … N−1. With `of_state` also for
  /// k = 1 … N−1 (N−1 lists), or with the last state's (N+1 lists, the last into `last`).
  c3::PerStage<VectorXd> bounds(const char* key, Eigen::Index size, double none, int N,
                                bool of_state, VectorXd* last) {
    if (!has(key) || at(key).is_null()) return {};
    const Json& value = at(key);
    require_list(key, value, "a list of " + std::to_string(size) + " numbers or null");
    const bool each = !value.empty() && value[0].is_array();
    if (!each) return bound(key, value, size, none);
    const int count = static_cast<int>(value.size());
    const bool fits = count == N || (of_state && (count == N - 1 || count == N + 1));
    if (!fits) {
      throw ConfigError(place(key) + ": expected one list or N = " + std::to_string(N) +
                        (of_state ? " (or N-1: without k = 0, or N+1: with x_N)" : "") + ", got " +
                        std::to_string(count));
    }
    std::vector<VectorXd> all;
    if (count == N - 1) all.push_back(VectorXd::Constant(size, none));
    for (int k = 0; k < count; ++k) {
      all.push_back(bound(std::string(key) + "[" + std::to_string(k) + "]", value[k], size, none));
    }
    if (count == N + 1) {
      *last = all.back();
      all.pop_back();
    }
    return all;
  }

  /// One number for all, or a list.
  VectorXd numbers(const char* key, Eigen::Index size) {
    const Json& value = at(key);
    if (value.is_array()) return vector(key, size);
    return VectorXd::Constant(size, as_number(key, value, -kInfinity, kInfinity));
  }

  /// Refuses the keys that nobody asked for.
  void finish() const {
    for (const auto& [key, value] : json_.items()) {
      if (used_.count(key) == 0) throw ConfigError(place(key) + ": unknown key");
    }
  }

  std::string place(const std::string& key) const {
    const std::string dot = path_.empty() || key.empty() ? "" : ".";
    return file_ + ": " + path_ + dot + key;
  }

 private:
  double as_number(const std::string& key, const Json& value, double min, double max) const {
    if (!value.is_number()) fail(key, "a number", value);
    const double x = value.get<double>();
    if (!std::isfinite(x)) fail(key, "a finite number", value);
    if (x < min || x > max) {
      std::ostringstream range;
      range << "a number in [" << min << ", " << max << "]";
      fail(key, range.str(), value);
    }
    return x;
  }

  void require_list(const std::string& key, const Json& value, const std::string& expected) const {
    if (!value.is_array()) fail(key, expected, value);
  }

  [[noreturn]] void fail(const std::string& key, const std::string& expected,
                         const Json& got) const {
    std::string text = got.is_structured()
                           ? std::string("a") + (got.is_array() ? " list" : "n object")
                           : got.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 60) + "…";
    throw ConfigError(place(key) + ": expected " + expected + ", got " + text);
  }

  const Json& json_;
  std::string file_, path_;
  std::set<std::string> used_;
};

/// Refuses an object that has a key twice: which one counts would be anybody's guess.
class DuplicateKeys {
 public:
  bool operator()(int depth, Json::parse_event_t event, Json& parsed) {
    const auto level = static_cast<std::size_t>(depth);
    if (event == Json::parse_event_t::object_start) {
      if (keys_.size() <= level + 1) keys_.resize(level + 2);
      keys_[level + 1].clear();
    }
    if (event == Json::parse_event_t::key) {
      if (keys_.size() <= level) keys_.resize(level + 1);
      const std::string key = parsed.get<std::string>();
      if (!keys_[level].insert(key).second) twice_ = key;
    }
    return true;
  }
  const std::string& twice() const { return twice_; }

 private:
  std::vector<std::set<std::string>> keys_;
  std::string twice_;
};

Json parse(const std::string& text, const std::string& name) {
  DuplicateKeys duplicates;
  Json json;
  try {
    json = Json::parse(quote_non_numbers(text), std::ref(duplicates));
  } catch (const Json::exception& error) {
    std::string what = error.what();  // "[json.exception.parse_error.101] parse error at line …"
    const std::size_t end = what.find("] ");
    throw ConfigError(
        name + ": expected JSON: " + (end == std::string::npos ? what : what.substr(end + 2)));
  }
  if (!duplicates.twice().empty()) {
    throw ConfigError(name + ": " + duplicates.twice() + ": expected each key once, got it twice");
  }
  return json;
}

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

/// A, F and B say the sizes, the other blocks have to agree.
lcs::Lcs read_lcs(const Json& json, const std::string& name, const std::string& path) {
  Reader reader(json, name, path);
  const Eigen::Index n_x = rows_of(json, "A"), n_lambda = rows_of(json, "F"),
                     n_u = cols_of(json, "B");
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
  for (const auto& [block, size] :
       {std::pair{"A", n_x}, std::pair{"F", n_lambda}, std::pair{"B", n_u}}) {
    if (size == 0) throw ConfigError(reader.place(block) + ": expected a matrix, got an empty one");
  }
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
  static const std::pair<const char*, const char*> kNames[] = {
      {"Costs.convex.Q_x", "params.Qx"},
      {"Costs.convex.Q_u", "params.Qu"},
      {"Costs.convex.alpha", "params.alpha"},
      {"Costs.convex.epsilon", "params.eps"},
      {"Costs.plus.", "params."},
      {"Costs.Q_N", "params.QN"},
      {"Costs.", "params."},
      {"Constraints.x_N_min", "params.xmin"},
      {"Constraints.x_N_max", "params.xmax"},
      {"Constraints.x_min", "params.xmin"},
      {"Constraints.x_max", "params.xmax"},
      {"Constraints.u_min", "params.umin"},
      {"Constraints.u_max", "params.umax"},
      {"Settings.admm_iterations", "params.s"},
      {"Settings.rho_scale", "params.rho_s"},
      {"Settings.rho", "params.rho"},
  };
  for (const auto& [ours, theirs] : kNames) {
    for (std::size_t at = message.find(ours); at != std::string::npos; at = message.find(ours)) {
      message.replace(at, std::char_traits<char>::length(ours), theirs);
    }
  }
  return message;
}

void read_costs(Reader& params, ProblemFile& p) {
  const auto [n_x, n_lambda, n_u, N] = p.sizes;
  const int n_z = p.sizes.n_z();
  p.costs.Q = params.matrices("Q", n_x, n_x, N);
  p.costs.Q_N = params.matrix("QN", n_x, n_x);
  p.costs.R = params.matrices("R", n_u, n_u, N);
  const bool c3 = p.method == Method::kC3;
  const c3::ProjectionKind kind = p.settings.projection;
  const bool plus = kind == c3::ProjectionKind::kPlus;
  // a parameter set may hold what another projection needs
  if (params.has("G") || (c3 && !plus)) p.costs.G = params.matrices("G", n_z, n_z, N);
  const bool needs_U = kind == c3::ProjectionKind::kMiqp || kind == c3::ProjectionKind::kAdmm;
  if (params.has("U") || (c3 && needs_U)) p.costs.U = params.matrix("U", n_z, n_z);
  if (params.has("Qx") || kind == c3::ProjectionKind::kConvex) {
    p.costs.convex.Q_x = params.matrix("Qx", n_x, n_x);
  }
  if (params.has("Qu") || kind == c3::ProjectionKind::kConvex) {
    p.costs.convex.Q_u = params.matrix("Qu", n_u, n_u);
  }
  if (params.has("alpha") || kind == c3::ProjectionKind::kConvex) {
    p.costs.convex.alpha = params.number("alpha", 0.0, 1.0);
  }
  p.costs.convex.epsilon = params.number("eps", 0.0, kInfinity, 0.0);
  for (const auto& [key, weight] :
       {std::pair{"g_lambda", &p.costs.plus.g_lambda}, std::pair{"g_eta", &p.costs.plus.g_eta},
        std::pair{"u_lambda", &p.costs.plus.u_lambda}, std::pair{"u_eta", &p.costs.plus.u_eta}}) {
    if (params.has(key) || plus) *weight = params.numbers(key, n_lambda);
  }
}

MatrixXd read_desired(Reader& params, const c3::Sizes& sizes) {
  const Json& value = params.at("xd");
  const bool each = value.is_array() && !value.empty() && value[0].is_array();
  if (each) return params.matrix("xd", sizes.N + 1, sizes.n_x).transpose();
  return params.vector("xd", sizes.n_x).replicate(1, sizes.N + 1);
}

ProblemFile read(const Json& json, const std::string& name) {
  Reader top(json, name, "");
  top.choice("schema", {"c3-problem-1"});
  ProblemFile p{};
  p.method = top.choice("method", {"C3", "MIQP15"}, 0) == 0 ? Method::kC3 : Method::kMiqp15;
  const std::vector<std::string> projections{"MIQP", "LCP", "ADMM", "CONVEX", "C3+"};
  constexpr c3::ProjectionKind kKinds[] = {c3::ProjectionKind::kMiqp, c3::ProjectionKind::kLcp,
                                           c3::ProjectionKind::kAdmm, c3::ProjectionKind::kConvex,
                                           c3::ProjectionKind::kPlus};
  p.settings.projection =
      kKinds[p.method == Method::kC3 ? top.choice("projection", projections)
                                     : top.choice("projection", projections, 0)];

  Reader params(top.at("params"), name, "params");
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
  settings.max_nodes = kMaxNodes;
  settings.project_last = true;  // the result's last iterate is whole, as in the golden files
  settings.trace = top.boolean("trace", false);
  p.big_M = params.number("M", 0.0, kInfinity, 1000.0);
  p.x_desired = read_desired(params, p.sizes);
  read_costs(params, p);
  c3::Constraints& c = p.constraints;
  c.x_min = params.bounds("xmin", of.n_x, -kInfinity, N, true, &c.x_N_min);
  c.x_max = params.bounds("xmax", of.n_x, kInfinity, N, true, &c.x_N_max);
  c.u_min = params.bounds("umin", of.n_u, -kInfinity, N, false, nullptr);
  c.u_max = params.bounds("umax", of.n_u, kInfinity, N, false, nullptr);
  params.finish();

  settings.osqp = {20000, 1e-8, 0.1, 50, true};
  const bool osqp = top.choice("qp", {"auto", "osqp", "direct"}, 0) == 1;
  settings.qp = osqp         ? c3::QpBackend::kOsqp
                : c3::any(c) ? c3::QpBackend::kInteriorPoint
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

Json to_json(const Eigen::Ref<const VectorXd>& v) {
  Json out = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) out.push_back(v[i]);
  return out;
}

/// Column by column: one list a stage.
Json columns(const MatrixXd& m) {
  Json out = Json::array();
  for (Eigen::Index k = 0; k < m.cols(); ++k) out.push_back(to_json(VectorXd(m.col(k))));
  return out;
}

const char* text(c3::ProjectionStatus status) {
  switch (status) {
    case c3::ProjectionStatus::kSolved:
      return "ok";
    case c3::ProjectionStatus::kNodeLimit:
      return "node limit";
    case c3::ProjectionStatus::kDeadline:
      return "deadline";
    case c3::ProjectionStatus::kNone:
      return "no point found";
    case c3::ProjectionStatus::kNotFinite:
      return "not finite";
  }
  return "";
}

std::string status_of(const c3::Solution& solution) {
  if (solution.status == c3::SolveStatus::kOk) return "ok";
  if (solution.status == c3::SolveStatus::kTruncated) return "truncated";
  switch (solution.failure) {
    case c3::Failure::kLambda0:
      return "fail: the LCP at x0 has no solution that Lemke's method finds";
    case c3::Failure::kQp:
      return solution.qp.status == c3::QpStatus::kInfeasible
                 ? "fail: the bounds cannot be met"
                 : "fail: the QP is beyond double precision";
    case c3::Failure::kProjection:
      return "fail: the projection found no point of the LCP's set";
    case c3::Failure::kNotFinite:
      return "fail: numbers beyond double precision";
    default:
      return "fail: not a problem that can be solved";
  }
}

/// 1 where λ is free and its gap zero, 0 where λ is zero.
Json modes(const ProblemFile& p, int k, const VectorXd& delta) {
  const lcs::Lcs& lcs = p.lcs[p.lcs.size() == 1 ? 0 : static_cast<std::size_t>(k)];
  const VectorXd lambda = p.sizes.lambda(delta);
  const VectorXd y = lcs.E * p.sizes.x(delta) + lcs.F * lambda + lcs.H * p.sizes.u(delta) + lcs.c;
  Json out = Json::array();
  for (Eigen::Index j = 0; j < y.size(); ++j) out.push_back(lambda[j] > y[j] ? 1 : 0);
  return out;
}

}  // namespace

ProblemFile parse_problem(const std::string& text, const std::string& name) {
  return read(parse(text, name), name);
}

ProblemFile load_problem(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError(path + ": expected a file that can be read");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw ConfigError(path + ": expected a file that can be read");
  return parse_problem(text, path);
}

ProblemResult to_result(const ProblemFile& problem, const c3::Solution& solution,
                        double solve_time_s) {
  const c3::Sizes& s = problem.sizes;
  MatrixXd x(s.n_x, s.N + 1);
  x << solution.z.topRows(s.n_x), solution.x_N;
  return {status_of(solution),
          x,
          solution.z.middleRows(s.n_x, s.n_lambda),
          solution.z.middleRows(s.n_x + s.n_lambda, s.n_u),
          c3::cost(problem.costs, s, problem.x_desired, solution.z, solution.x_N),
          solution.complementarity_violation,
          solution.iterations,
          solve_time_s};
}

std::string to_json(const ProblemFile& problem, const ProblemResult& result,
                    const std::vector<c3::Iterate>& iterates) {
  Json json{{"schema", "c3-result-1"},
            {"status", result.status},
            {"u0", to_json(VectorXd(result.u.col(0)))},
            {"x", columns(result.x)},
            {"lam", columns(result.lambda)},
            {"u", columns(result.u)},
            {"objective", result.objective},
            {"complementarity_violation", result.complementarity_violation},
            {"iterations", result.iterations},
            {"solve_time_s", result.solve_time_s}};
  if (!problem.settings.trace) return json.dump(1) + "\n";
  Json iters = Json::array();
  for (int i = 0; i < result.iterations && i < static_cast<int>(iterates.size()); ++i) {
    const c3::Iterate& iterate = iterates[static_cast<std::size_t>(i)];
    // of a failed solve the complete turns, as in the golden files
    if (iterate.projections == 0 && result.status.rfind("fail", 0) == 0) break;
    Json projections = Json::array();
    for (int k = 0; k < iterate.projections; ++k) {
      const c3::ProjectionReport& report = iterate.projection[static_cast<std::size_t>(k)];
      projections.push_back({{"status", text(report.status)},
                             {"obj", report.objective},
                             {"nodes", report.nodes},
                             {"mode", modes(problem, k, iterate.delta.col(k))}});
    }
    iters.push_back({{"rho", iterate.rho},
                     {"z", columns(iterate.z)},
                     {"xN", to_json(iterate.x_N)},
                     {"delta", columns(iterate.delta)},
                     {"w", columns(iterate.w)},
                     {"proj", projections}});
  }
  json["iters"] = iters;
  return json.dump(1) + "\n";
}

}  // namespace c3rt::config
