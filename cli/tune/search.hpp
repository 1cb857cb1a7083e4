#pragma once
// What `c3rt tune` looks for: keys of a scenario, each with a range, seen as numbers in [0, 1].
#include <string>
#include <vector>

#include <Eigen/Core>

#include "config/tree.hpp"

namespace c3rt::cli::tune {

enum class Scale { kLinear, kLogarithmic, kWhole };

/// One number of the search. Several keys may share it.
struct Parameter {
  std::vector<std::string> keys;  // "planner.weights.roll.Q.ball_xy"
  Scale scale;
  double low, high;  // in the keys' units
};

/// "planner.admm.rho=0.1..10", "a.b,a.c=1..100". @throws UsageError saying what was expected
Parameter parse_parameter(Scale scale, const std::string& text);

/// A value's place in the range, and back. A whole number is the nearest.
double to_unit(const Parameter& parameter, double value);
double from_unit(const Parameter& parameter, double unit);

/// What the scenario has, in [0, 1]. @param file for messages
/// @throws UsageError for a key that is not there, is no number, differs from the one that shares
/// its parameter or lies outside the range, and for a key that is named twice
Eigen::VectorXd start(const std::vector<Parameter>& parameters, const config::Tree& scenario,
                      const std::string& file);

/// "planner.admm.rho=0.316228": six digits, as a person would write them.
std::vector<std::string> assignments(const std::vector<Parameter>& parameters,
                                     const Eigen::VectorXd& unit);

}  // namespace c3rt::cli::tune
