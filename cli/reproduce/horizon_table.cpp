#include "cli/reproduce/horizon_table.hpp"

#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "cli/reproduce/loop.hpp"

namespace c3rt::cli::reproduce {
namespace {

using Row = std::vector<std::string>;

/// A way to control, and what it gave at each horizon.
struct Column {
  std::string key, name, short_name, color;
  Overrides overrides;
  bool monolithic;
  std::vector<ordered_json> figures = {};
};

void measure(const Context& context, const HorizonTable& table, Column& column) {
  for (const int N : kHorizons) {
    if (context.settings().quick && N != kHorizons.front()) {
      column.figures.push_back(ordered_json::object());
      continue;
    }
    Overrides overrides = column.overrides;
    overrides.push_back(fmt::format("control.horizon={}", N));
    const std::string name = fmt::format("{}-{}", column.key, N);
    ordered_json inputs = ordered_json::object();
    if (column.monolithic)
      inputs = {{"miqp_limit_s", context.settings().miqp_limit}, {"starter", table.own}};
    column.figures.push_back(context.part(name, table.scenario, overrides, inputs, [&] {
      const ExampleScenario scenario = context.scenario(table.scenario, overrides);
      Overrides own = overrides;
      own.insert(own.end(), table.own.begin(), table.own.end());
      const ExampleScenario starter = context.scenario(table.scenario, own);
      const std::string title = fmt::format("{}, N = {}", column.name, N);
      return column.monolithic ? measure_monolithic(context, title, scenario, starter)
                               : measure_c3(context, title, scenario);
    }));
  }
}

template <typename Value>
Row row(const std::string& name, const Column& column, Value value) {
  Row cells{"  " + name};
  for (const ordered_json& figures : column.figures)
    cells.push_back(figures.empty() ? "-" : value(figures));
  return cells;
}

Row row(const Reference& reference) {
  Row cells{"  " + reference.name};
  for (const char* value : reference.values) cells.emplace_back(value);
  return cells;
}

std::string p50_ms(const ordered_json& figures) {
  return shown(figures["solve_time_s"]["p50"], 1e3, 3);
}

Curve curve(const Column& column, const std::function<double(const ordered_json&)>& value) {
  Eigen::VectorXd N(kHorizons.size()), y(kHorizons.size());
  for (std::size_t i = 0; i < kHorizons.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    N[k] = kHorizons[i];
    y[k] = column.figures[i].empty() ? kNone : value(column.figures[i]);
  }
  return {"here: " + column.short_name, column.color, N, y, false, true};
}

Curve curve(const Reference& reference, const std::string& color) {
  Eigen::VectorXd N(kHorizons.size()), y(kHorizons.size());
  for (std::size_t i = 0; i < kHorizons.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    N[k] = kHorizons[i];
    char* end = nullptr;
    y[k] = std::strtod(reference.values[i], &end);
    if (end == reference.values[i]) y[k] = kNone;
  }
  return {reference.name, color, N, y, true, true};
}

}  // namespace

void run_horizon_table(const Context& context, const HorizonTable& table) {
  const double limit = context.settings().miqp_limit;
  Overrides own = table.published;
  own.insert(own.end(), table.own.begin(), table.own.end());
  std::vector<Column> columns{
      {"c3", "C3, published settings", "C3", "#1f5fd0", table.published, false},
      {"own", "C3, " + table.own_words, "C3, own settings", "#2a8f4a", own, false},
      {"miqp", fmt::format("MIQP (15) from C3's plan, {:g} s limit", limit), "MIQP", "#d04020",
       table.published, true}};
  for (Column& column : columns) measure(context, table, column);

  const std::string cost_label =
      fmt::format("accumulated cost [10^{:.0f}]", std::log10(table.cost_unit));
  fmt::print("{}\n\n", table.title);
  std::vector<Row> rows{{"horizon N"}};
  for (const int N : kHorizons) rows.front().push_back(std::to_string(N));
  rows.push_back({"solve time [ms], median of the calls"});
  for (const Reference& reference : table.times) rows.push_back(row(reference));
  for (const Column& column : columns) rows.push_back(row("here: " + column.name, column, p50_ms));
  rows.push_back({cost_label});
  for (const Reference& reference : table.costs) rows.push_back(row(reference));
  for (const Column& column : columns) {
    rows.push_back(row("here: " + column.name, column, [&](const ordered_json& figures) {
      return shown(figures["accumulated_cost"], 1.0 / table.cost_unit);
    }));
  }
  if (table.has_limits) {
    rows.push_back({"largest overshoot of the limits between the control steps [m]"});
    for (const Column& column : columns) {
      rows.push_back(row("here: " + column.name, column, [](const ordered_json& figures) {
        return shown(figures["overshoot"], 1.0, 2);
      }));
    }
  }
  const Column& miqp = columns.back();
  rows.push_back({"what the MIQP's search here proved"});
  rows.push_back(row("calls proven within a gap of 1e-4", miqp, [](const ordered_json& figures) {
    return fmt::format("{}/{}", figures["proven"].get<int>(), figures["calls"].get<int>());
  }));
  rows.push_back(row("gap, mean [%]", miqp, [](const ordered_json& figures) {
    return shown(figures["gap_mean"], 100.0, 2);
  }));
  rows.push_back(row("calls without a plan", miqp, [](const ordered_json& figures) {
    return std::to_string(figures["controller_failures"].get<int>());
  }));
  print_table(rows);

  ordered_json results{{"what", context.settings().what}, {"miqp_limit_s", limit}};
  Panel times{"", "", "solve time [ms]", {}, {}, true};
  Panel costs{"", "horizon N", cost_label, {}};
  for (const Column& column : columns) {
    for (std::size_t i = 0; i < kHorizons.size(); ++i)
      results[column.key][std::to_string(kHorizons[i])] = column.figures[i];
    times.curves.push_back(curve(column, [](const ordered_json& figures) {
      return figures["solve_time_s"]["p50"].get<double>() * 1e3;
    }));
    costs.curves.push_back(curve(column, [&](const ordered_json& figures) {
      return figures["accumulated_cost"].get<double>() / table.cost_unit;
    }));
  }
  const std::array<const char*, 4> greys{"#202020", "#808080", "#b08000", "#9050a0"};
  for (std::size_t i = 0; i < table.times.size(); ++i)
    times.curves.push_back(curve(table.times[i], greys[i % greys.size()]));
  for (std::size_t i = 0; i < table.costs.size(); ++i)
    costs.curves.push_back(curve(table.costs[i], greys[i % greys.size()]));
  context.finish(results, table.title, {times, costs});
}

}  // namespace c3rt::cli::reproduce
