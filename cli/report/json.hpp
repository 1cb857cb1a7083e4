#pragma once
// How figures stand in a report, whichever command writes it.
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "cli/report/metrics.hpp"

namespace c3rt::cli {

/// null where a value is not finite: the run did not give it.
nlohmann::ordered_json number(double value);
nlohmann::ordered_json numbers(const Eigen::VectorXd& values);

/// {p50, p95, p99, max}
nlohmann::ordered_json quantiles(const Spread& spread);

/// [{name, value, limit, met}]
nlohmann::ordered_json to_json(const std::vector<CriterionResult>& criteria);

}  // namespace c3rt::cli
