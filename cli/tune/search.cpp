#include "cli/tune/search.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "config/override.hpp"

namespace c3rt::cli::tune {
namespace {

constexpr const char* kOptions[] = {"--linear", "--log", "--whole"};

std::string option(Scale scale) { return kOptions[static_cast<int>(scale)]; }

bool read_number(const std::string& text, double& value) {
  std::size_t used = 0;
  try {
    value = std::stod(text, &used);
  } catch (const std::logic_error&) {
    return false;
  }
  return used == text.size() && std::isfinite(value);
}

double raised(Scale scale, double value) {
  return scale == Scale::kLogarithmic ? std::log(value) : value;
}

}  // namespace

Parameter parse_parameter(Scale scale, const std::string& text) {
  const std::size_t equals = text.find('='), dots = text.find("..", equals + 1);
  Parameter parameter{{}, scale, 0.0, 0.0};
  const bool is_range = equals != std::string::npos && dots != std::string::npos &&
                        read_number(text.substr(equals + 1, dots - equals - 1), parameter.low) &&
                        read_number(text.substr(dots + 2), parameter.high);
  if (is_range) {
    std::istringstream keys(text.substr(0, equals));
    for (std::string key; std::getline(keys, key, ',');) parameter.keys.push_back(key);
  }
  const auto is_empty = [](const std::string& key) { return key.empty(); };
  if (parameter.keys.empty() || text[equals - 1] == ',' ||
      std::any_of(parameter.keys.begin(), parameter.keys.end(), is_empty)) {
    throw UsageError(
        fmt::format("{}: expected KEY=LOW..HIGH, for example planner.admm.rho=0.1..10, got {}",
                    option(scale), text));
  }
  if (parameter.low >= parameter.high) {
    throw UsageError(fmt::format("{}: expected the lower end before the higher one, got {}",
                                 option(scale), text));
  }
  if (scale == Scale::kLogarithmic && parameter.low <= 0.0) {
    throw UsageError(fmt::format("--log: expected a range above 0, got {}", text));
  }
  if (scale == Scale::kWhole &&
      (std::round(parameter.low) != parameter.low || std::round(parameter.high) != parameter.high))
    throw UsageError(fmt::format("--whole: expected whole numbers, got {}", text));
  return parameter;
}

double to_unit(const Parameter& parameter, double value) {
  const double low = raised(parameter.scale, parameter.low);
  return (raised(parameter.scale, value) - low) / (raised(parameter.scale, parameter.high) - low);
}

double from_unit(const Parameter& parameter, double unit) {
  const double low = raised(parameter.scale, parameter.low);
  const double at =
      low + std::clamp(unit, 0.0, 1.0) * (raised(parameter.scale, parameter.high) - low);
  if (parameter.scale == Scale::kLogarithmic)
    return std::clamp(std::exp(at), parameter.low, parameter.high);
  return parameter.scale == Scale::kWhole ? std::round(at) : at;
}

Eigen::VectorXd start(const std::vector<Parameter>& parameters, const config::Tree& scenario,
                      const std::string& file) {
  Eigen::VectorXd unit(static_cast<Eigen::Index>(parameters.size()));
  std::set<std::string> named;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& parameter = parameters[i];
    const std::string said = option(parameter.scale) + " ";
    double shared = 0.0;
    for (const std::string& key : parameter.keys) {
      if (!named.insert(key).second) throw UsageError(said + key + ": is named twice");
      const config::Tree* tree = config::value_at(scenario, key);
      if (tree == nullptr) throw UsageError(said + key + ": no such key in " + file);
      double value = 0.0;
      if (!tree->is_scalar() || !read_number(tree->scalar, value)) {
        throw UsageError(fmt::format("{}{}: expected a number in {}, got {}", said, key, file,
                                     config::content(*tree)));
      }
      if (value < parameter.low || value > parameter.high) {
        throw UsageError(
            fmt::format("{}{}: expected the scenario's own value in {:g} to {:g}, got "
                        "{:g} (--set gives another start)",
                        said, key, parameter.low, parameter.high, value));
      }
      if (&key != &parameter.keys.front() && value != shared) {
        throw UsageError(
            fmt::format("{}{}: expected the value of {}, {:g}, got {:g}: keys that "
                        "share a number begin with the same",
                        said, key, parameter.keys.front(), shared, value));
      }
      shared = value;
    }
    unit[static_cast<Eigen::Index>(i)] = to_unit(parameter, shared);
  }
  return unit;
}

std::vector<std::string> assignments(const std::vector<Parameter>& parameters,
                                     const Eigen::VectorXd& unit) {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = from_unit(parameters[i], unit[static_cast<Eigen::Index>(i)]);
    for (const std::string& key : parameters[i].keys)
      all.push_back(fmt::format("{}={:.6g}", key, value));
  }
  return all;
}

}  // namespace c3rt::cli::tune
