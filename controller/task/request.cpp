#include "controller/task/request.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "controller/base/words.hpp"

namespace c3rt::task {
namespace {

std::string text(double value) { return base::words("%g", value); }

std::string range(double min, double max) { return "from " + text(min) + " to " + text(max); }

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// What came: "0.5", "3 numbers", "\"word\"".
std::string content(const Parameter& parameter) {
  if (!parameter.word.empty()) return "\"" + parameter.word + "\"";
  if (parameter.values.size() == 1) return text(parameter.values.front());
  return std::to_string(parameter.values.size()) + " numbers";
}

}  // namespace

Parameter parse_parameter(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
    throw RequestError("expected a parameter as KEY=VALUE or KEY=VALUE,VALUE, got \"" + text +
                       "\"");
  Parameter parameter{text.substr(0, equals), {}, ""};
  const std::string value = text.substr(equals + 1);
  if (value == "true" || value == "false") {
    parameter.values = {value == "true" ? 1.0 : 0.0};
    return parameter;
  }
  for (const char* at = value.c_str();;) {
    char* end = nullptr;
    parameter.values.push_back(std::strtod(at, &end));
    if (end == at || (*end != ',' && *end != '\0')) {
      parameter.values.clear();
      parameter.word = value;
      return parameter;
    }
    if (*end == '\0') return parameter;
    at = end + 1;
  }
}

void RequestSource::fail(const std::string& key, const std::string& expected,
                         const std::string& got) {
  throw RequestError(request_.kind + ": " + key + ": expected " + expected + ", got " + got);
}

bool RequestSource::has(const std::string& key) {
  asked_.push_back(key);
  return std::any_of(request_.parameters.begin(), request_.parameters.end(),
                     [&](const Parameter& parameter) { return parameter.name == key; });
}

const Parameter& RequestSource::find(const std::string& key, const std::string& expected) {
  if (asked_.empty() || asked_.back() != key) asked_.push_back(key);
  for (const Parameter& parameter : request_.parameters) {
    if (parameter.name == key) return parameter;
  }
  fail(key, expected, "nothing");
}

const std::vector<double>& RequestSource::values(const std::string& key,
                                                 const std::string& expected, double min,
                                                 double max) {
  const Parameter& parameter = find(key, expected);
  if (!parameter.word.empty() || parameter.values.empty()) fail(key, expected, content(parameter));
  for (const double value : parameter.values) {
    // written so that NaN fails
    if (!(value >= min && value <= max)) fail(key, expected, text(value));
  }
  return parameter.values;
}

double RequestSource::number(const std::string& key, double min, double max) {
  return numbers(key, 1, min, max)[0];
}

bool RequestSource::boolean(const std::string& key) {
  const std::string expected = "0 or 1";
  const double value = number(key, 0.0, 1.0);
  if (value != 0.0 && value != 1.0) fail(key, expected, text(value));
  return value == 1.0;
}

Eigen::VectorXd RequestSource::numbers(const std::string& key, int size, double min, double max) {
  const std::string expected =
      (size == 1 ? "a number " : std::to_string(size) + " numbers ") + range(min, max);
  const std::vector<double>& given = values(key, expected, min, max);
  if (given.size() != static_cast<std::size_t>(size))
    fail(key, expected, std::to_string(given.size()) + " numbers");
  return Eigen::Map<const Eigen::VectorXd>(given.data(), size);
}

Eigen::VectorXd RequestSource::one_or_each(const std::string& key, int size, double min,
                                           double max) {
  const std::string expected =
      "one number or " + std::to_string(size) + ", each " + range(min, max);
  const std::vector<double>& given = values(key, expected, min, max);
  if (given.size() == 1) return Eigen::VectorXd::Constant(size, given.front());
  if (given.size() != static_cast<std::size_t>(size))
    fail(key, expected, std::to_string(given.size()) + " numbers");
  return Eigen::Map<const Eigen::VectorXd>(given.data(), size);
}

Eigen::MatrixXd RequestSource::rows(const std::string& key, int min_rows, int max_rows, int columns,
                                    double min, double max) {
  const std::string expected = std::to_string(min_rows) + " to " + std::to_string(max_rows) +
                               " times " + std::to_string(columns) + " numbers " + range(min, max);
  const std::vector<double>& given = values(key, expected, min, max);
  const auto count = static_cast<int>(given.size());
  if (count % columns != 0 || count / columns < min_rows || count / columns > max_rows)
    fail(key, expected, std::to_string(count) + " numbers");
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(given.data(), count / columns, columns);
}

int RequestSource::choice(const std::string& key, const std::vector<std::string>& names) {
  const std::string expected = "one of " + listed(names);
  const bool of_kind = key == "kind";
  std::string word = request_.kind;
  if (!of_kind) {
    const Parameter& parameter = find(key, expected);
    word = parameter.word;
    if (word.empty()) fail(key, expected, content(parameter));
  }
  const auto found = std::find(names.begin(), names.end(), word);
  if (found == names.end() && of_kind)
    throw RequestError("kind: expected " + expected + ", got \"" + word + "\"");
  if (found == names.end()) fail(key, expected, "\"" + word + "\"");
  return static_cast<int>(found - names.begin());
}

void RequestSource::finish() const {
  std::vector<std::string> seen;
  for (const Parameter& parameter : request_.parameters) {
    if (std::find(asked_.begin(), asked_.end(), parameter.name) == asked_.end()) {
      throw RequestError(
          request_.kind + ": expected " +
          (asked_.empty() ? "no parameters" : "no other parameters than " + listed(asked_)) +
          ", got \"" + parameter.name + "\"");
    }
    if (std::find(seen.begin(), seen.end(), parameter.name) != seen.end())
      throw RequestError(request_.kind + ": " + parameter.name + ": expected once, got it twice");
    seen.push_back(parameter.name);
  }
}

}  // namespace c3rt::task
