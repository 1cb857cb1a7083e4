#include "cli/report/json.hpp"

#include <cmath>

namespace c3rt::cli {

using nlohmann::ordered_json;

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json numbers(const Eigen::VectorXd& values) {
  ordered_json list = ordered_json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

ordered_json quantiles(const Spread& spread) {
  return {{"p50", number(spread.p50)},
          {"p95", number(spread.p95)},
          {"p99", number(spread.p99)},
          {"max", number(spread.max)}};
}

ordered_json to_json(const std::vector<CriterionResult>& criteria) {
  ordered_json list = ordered_json::array();
  for (const CriterionResult& c : criteria) {
    list.push_back(
        {{"name", c.name}, {"value", number(c.value)}, {"limit", c.limit}, {"met", c.met}});
  }
  return list;
}

}  // namespace c3rt::cli
