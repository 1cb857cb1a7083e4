#include "cli/reproduce/context.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "cli/paths.hpp"

namespace c3rt::cli::reproduce {
namespace {

constexpr double kQuickDuration = 0.3;  // [s]

std::string read_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// Columns on a terminal: bytes that begin a UTF-8 letter.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

Context::Context(const Settings& settings, const Stop& stop)
    : settings_(settings),
      stop_(stop),
      out_(make_folder(settings.out.empty() ? std::filesystem::path("out/reproduce")
                                            : std::filesystem::path(settings.out))) {
  make_folder(out_ / "parts");
}

Overrides Context::shortened(const Overrides& overrides) const {
  Overrides all = overrides;
  if (settings_.quick) all.push_back(fmt::format("control.duration_s={}", kQuickDuration));
  return all;
}

ExampleScenario Context::scenario(const std::string& name, const Overrides& overrides) const {
  return load_example(scenario_path(name), shortened(overrides));
}

ordered_json Context::part(const std::string& name, const std::string& scenario,
                           const Overrides& overrides, const ordered_json& inputs,
                           const std::function<ordered_json()>& compute) const {
  const std::filesystem::path file = out_ / "parts" / (settings_.what + "-" + name + ".json");
  const ordered_json key{{"scenario", read_text(scenario_path(scenario))},
                         {"overrides", shortened(overrides)},
                         {"inputs", inputs}};
  if (!settings_.fresh && std::filesystem::is_regular_file(file)) {
    const ordered_json kept = ordered_json::parse(read_text(file), nullptr, false);
    if (kept.is_object() && kept.value("key", ordered_json()) == key) {
      fmt::print(stderr, "{}: kept from an earlier run ({})\n", name, file.string());
      return kept.at("value");
    }
  }
  if (stopped()) throw Interrupted{};
  const ordered_json value = compute();
  write_text(file, ordered_json{{"key", key}, {"value", value}}.dump(1) + "\n");
  return value;
}

void Context::finish(const ordered_json& results, const std::string& title,
                     const std::vector<Panel>& panels) const {
  const std::filesystem::path json = out_ / (settings_.what + ".json"),
                              picture = out_ / (settings_.what + ".png");
  write_text(json, results.dump(1) + "\n");
  const std::string missing = draw_panels(picture, title, panels);
  if (missing.empty()) {
    fmt::print("\n{}\n{}\n", json.string(), picture.string());
  } else {
    fmt::print("\n{}\n", json.string());
    fmt::print(stderr, "c3rt: {}\n", missing);
  }
}

void print_table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    if (row.size() < 2) continue;
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::size_t missing =
          row.size() < 2 ? 0 : widths[i] - std::min(widths[i], width(row[i]));
      const std::string space(missing, ' ');
      line += i == 0 ? row[i] + space : "  " + space + row[i];
    }
    fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  }
}

std::string shown(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "-";
}

std::string shown(const ordered_json& value, double factor, int digits) {
  return value.is_number() ? shown(value.get<double>() * factor, digits) : "-";
}

Eigen::VectorXd to_vector(const ordered_json& list) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = list[i].is_number() ? list[i].get<double>() : kNone;
  return values;
}

}  // namespace c3rt::cli::reproduce
