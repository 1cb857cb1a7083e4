#include "config/json_reader.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <utility>

namespace c3rt::config {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

}  // namespace

JsonReader::JsonReader(const Json& json, std::string file, std::string path)
    : json_(json), file_(std::move(file)), path_(std::move(path)) {
  if (!json.is_object()) fail("", "an object", json);
}

bool JsonReader::has(const char* key) {
  used_.insert(key);
  return json_.contains(key);
}

const Json& JsonReader::at(const char* key) {
  used_.insert(key);
  const auto found = json_.find(key);
  if (found == json_.end()) throw ConfigError(place(key) + ": expected a value, got none");
  return *found;
}

double JsonReader::number(const char* key, double min, double max) {
  return as_number(key, at(key), min, max);
}

double JsonReader::number(const char* key, double min, double max, double missing) {
  return has(key) ? number(key, min, max) : missing;
}

int JsonReader::integer(const char* key, int min, int max) {
  const Json& value = at(key);
  if (!value.is_number_integer() || value.get<double>() < min || value.get<double>() > max) {
    fail(key, "an integer in [" + std::to_string(min) + ", " + std::to_string(max) + "]", value);
  }
  return value.get<int>();
}

int JsonReader::integer(const char* key, int min, int max, int missing) {
  return has(key) ? integer(key, min, max) : missing;
}

bool JsonReader::boolean(const char* key, bool missing) {
  if (!has(key)) return missing;
  if (!at(key).is_boolean()) fail(key, "true or false", at(key));
  return at(key).get<bool>();
}

std::size_t JsonReader::choice(const char* key, const std::vector<std::string>& choices) {
  const Json& value = at(key);
  std::string names;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (value.is_string() && value.get<std::string>() == choices[i]) return i;
    names += (i == 0 ? "" : ", ") + choices[i];
  }
  fail(key, "one of " + names, value);
}

std::size_t JsonReader::choice(const char* key, const std::vector<std::string>& choices,
                               std::size_t missing) {
  return has(key) ? choice(key, choices) : missing;
}

VectorXd JsonReader::vector(const char* key, Eigen::Index size) {
  return vector(key, at(key), size);
}

VectorXd JsonReader::vector(const std::string& key, const Json& value, Eigen::Index size) const {
  require_values(key, value, size, "numbers");
  VectorXd out(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    out[i] = as_number(key + "[" + std::to_string(i) + "]", value[i], -kInfinity, kInfinity);
  }
  return out;
}

MatrixXd JsonReader::matrix(const char* key, Eigen::Index rows, Eigen::Index cols) {
  return matrix(key, at(key), rows, cols);
}

MatrixXd JsonReader::matrix(const std::string& key, const Json& value, Eigen::Index rows,
                            Eigen::Index cols) const {
  if (rows == kAnyRows) rows = static_cast<Eigen::Index>(value.size());
  require_list(key, value, "a matrix " + shape(rows, cols) + ", a list of its rows");
  if (value.empty() && (rows == 0 || cols == 0)) return MatrixXd(rows, cols);
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
    throw ConfigError(place(key) + ": expected " + shape(rows, cols) + ", got " +
                      shape(static_cast<Eigen::Index>(value.size()), widest));
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

c3::PerStage<MatrixXd> JsonReader::matrices(const char* key, Eigen::Index rows, Eigen::Index cols,
                                            int N) {
  const Json& value = at(key);
  const auto is_matrix = [](const Json& one) {
    return one.is_array() && !one.empty() && one[0].is_array();
  };
  const auto is_empty = [](const Json& one) { return one.is_array() && one.empty(); };
  const bool some = value.is_array() && std::any_of(value.begin(), value.end(), is_matrix);
  const bool none = value.is_array() && !value.empty() && rows <= 0 &&
                    std::all_of(value.begin(), value.end(), is_empty);
  if (!some && !none) return matrix(key, rows, cols);
  if (static_cast<int>(value.size()) != N) {
    throw ConfigError(place(key) + ": expected one matrix or N = " + std::to_string(N) + ", got " +
                      std::to_string(value.size()));
  }
  std::vector<MatrixXd> all;
  for (int k = 0; k < N; ++k) {
    all.push_back(matrix(std::string(key) + "[" + std::to_string(k) + "]", value[k], rows, cols));
  }
  return all;
}

VectorXd JsonReader::bound(const std::string& key, const Json& value, Eigen::Index size,
                           double none) const {
  require_values(key, value, size, "numbers or null");
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

c3::PerStage<VectorXd> JsonReader::bounds(const char* key, const std::vector<Eigen::Index>& sizes,
                                          double none, bool of_state, VectorXd* last) {
  if (!has(key) || at(key).is_null()) return {};
  const Json& value = at(key);
  const int N = static_cast<int>(sizes.size());
  const bool alike = std::equal(sizes.begin() + 1, sizes.end(), sizes.begin());
  require_list(key, value,
               alike ? "a list of " + std::to_string(sizes[0]) + " numbers or null"
                     : "N = " + std::to_string(N) + " lists of numbers or null");
  const bool each = !alike || (!value.empty() && value[0].is_array());
  if (!each) return bound(key, value, sizes[0], none);
  const int count = static_cast<int>(value.size());
  const bool fits = count == N || (of_state && (count == N - 1 || count == N + 1));
  if (!fits) {
    throw ConfigError(place(key) + ": expected one list or N = " + std::to_string(N) +
                      (of_state ? " (or N-1: without k = 0, or N+1: with x_N)" : "") + ", got " +
                      std::to_string(count));
  }
  std::vector<VectorXd> all;
  if (count == N - 1) all.emplace_back(VectorXd::Constant(sizes[0], none));
  for (int k = 0; k < count; ++k) {
    all.push_back(bound(std::string(key) + "[" + std::to_string(k) + "]", value[k],
                        sizes[k < N ? static_cast<std::size_t>(k) : 0], none));
  }
  if (count == N + 1) {
    *last = all.back();
    all.pop_back();
  }
  return all;
}

VectorXd JsonReader::numbers(const char* key, Eigen::Index size) {
  const Json& value = at(key);
  if (value.is_array()) return vector(key, size);
  return VectorXd::Constant(size, as_number(key, value, -kInfinity, kInfinity));
}

void JsonReader::finish() const {
  for (const auto& [key, value] : json_.items()) {
    if (used_.count(key) == 0) throw ConfigError(place(key) + ": unknown key");
  }
}

std::string JsonReader::place(const std::string& key) const {
  const std::string dot = path_.empty() || key.empty() ? "" : ".";
  return file_ + ": " + path_ + dot + key;
}

double JsonReader::as_number(const std::string& key, const Json& value, double min,
                             double max) const {
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

void JsonReader::require_values(const std::string& key, const Json& value, Eigen::Index size,
                                const std::string& what) const {
  require_list(key, value, "a list of " + std::to_string(size) + " " + what);
  if (static_cast<Eigen::Index>(value.size()) != size) {
    throw ConfigError(place(key) + ": expected " + std::to_string(size) + " values, got " +
                      std::to_string(value.size()));
  }
}

void JsonReader::require_list(const std::string& key, const Json& value,
                              const std::string& expected) const {
  if (!value.is_array()) fail(key, expected, value);
}

void JsonReader::fail(const std::string& key, const std::string& expected, const Json& got) const {
  std::string text = got.is_structured()
                         ? std::string("a") + (got.is_array() ? " list" : "n object")
                         : got.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 60) + "…";
  throw ConfigError(place(key) + ": expected " + expected + ", got " + text);
}

nlohmann::json parse_json(const std::string& text, const std::string& name) {
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

}  // namespace c3rt::config
