#include "cli/reproduce/context.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "cli/paths.hpp"
#include "config/show.hpp"

namespace c3rt::cli::reproduce {
namespace {

constexpr double kQuickDuration = 0.3, kQuickRun = 6.0;  // of an example, of a run [s]

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
  const ordered_json key{{"scenario", config::whole_scenario(scenario_path(scenario).string())},
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
  ordered_json value = compute();
  write_text(file, ordered_json{{"key", key}, {"value", value}}.dump(1) + "\n");
  return value;
}

std::vector<RunGroup> Context::groups(std::vector<RunSpec> specs) const {
  for (RunSpec& spec : specs) {
    spec.name = settings_.what + "-" + spec.name;
    if (settings_.quick) spec.duration = kQuickRun;
  }
  return run_all(specs, {out_ / "runs", settings_.what, settings_.fresh, stop_});
}

std::vector<Run> Context::runs(const std::vector<RunSpec>& specs) const {
  std::vector<Run> all;
  for (RunGroup& group : groups(specs)) all.push_back(std::move(group.runs.front()));
  return all;
}

void Context::finish(const ordered_json& results, const std::string& title,
                     const std::vector<Panel>& panels) const {
  finish(results, draw_panels(picture(), title, panels));
}

void Context::finish(const ordered_json& results, const std::string& missing) const {
  finish(results);
  if (missing.empty()) {
    fmt::print("{}\n", picture().string());
  } else {
    fmt::print(stderr, "c3rt: {}\n", missing);
  }
}

void Context::finish(const ordered_json& results) const {
  const std::filesystem::path json = out_ / (settings_.what + ".json");
  write_text(json, results.dump(1) + "\n");
  fmt::print("\n{}\n", json.string());
}

void print_table(const Rows& rows) { fmt::print("{}", text_table(rows)); }

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
