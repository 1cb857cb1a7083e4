#pragma once
// What every target has: settings, scenarios, the parts that an earlier call finished, its results.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "cli/example/scenario.hpp"
#include "cli/report/json.hpp"
#include "cli/report/panels.hpp"
#include "cli/report/text_table.hpp"
#include "cli/reproduce/reproduce.hpp"
#include "cli/reproduce/runs.hpp"

namespace c3rt::cli::reproduce {

using nlohmann::ordered_json;
using Overrides = std::vector<std::string>;

class Context {
 public:
  /// @throws UsageError if the folder cannot be made
  Context(const Settings& settings, const Stop& stop);

  const Settings& settings() const { return settings_; }
  bool stopped() const { return stop_(); }

  /// An example with these keys replaced, shortened where a quick look is wanted.
  ExampleScenario scenario(const std::string& name, const Overrides& overrides) const;

  /// The part's value: from an earlier call with the same scenario, overrides and settings, or
  /// computed now and kept.
  /// @param inputs what else the value depends on
  ordered_json part(const std::string& name, const std::string& scenario,
                    const Overrides& overrides, const ordered_json& inputs,
                    const std::function<ordered_json()>& compute) const;

  /// Runs of the four processes in lockstep, several at once, each in runs/WHAT-NAME; those of an
  /// earlier call with the same scenario, settings and programs are kept. Short where a quick look
  /// is wanted.
  /// @throws as run_all
  std::vector<RunGroup> groups(std::vector<RunSpec> specs) const;
  /// The one run of each of these specs.
  std::vector<Run> runs(const std::vector<RunSpec>& specs) const;

  /// Where finish() expects the picture.
  std::filesystem::path picture() const { return out_ / (settings_.what + ".png"); }
  /// Writes WHAT.json and says where it and the picture are.
  /// @param missing what drawing the picture returned
  void finish(const ordered_json& results, const std::string& missing) const;
  /// The same of results that have no picture.
  void finish(const ordered_json& results) const;
  /// The same with a picture of panels.
  void finish(const ordered_json& results, const std::string& title,
              const std::vector<Panel>& panels) const;

 private:
  Overrides shortened(const Overrides& overrides) const;
  Settings settings_;
  Stop stop_;
  std::filesystem::path out_;
};

void print_table(const Rows& rows);

/// Of at most this many digits, "-" where there is none.
using cli::shown;
std::string shown(const ordered_json& value, double factor = 1.0, int digits = 4);

Eigen::VectorXd to_vector(const ordered_json& list);

// the targets
void comparison(const Context& context);
void table1(const Context& context);
void table2(const Context& context);
void table3(const Context& context);
void fig3(const Context& context);
void fig5(const Context& context);
void fig7(const Context& context);
void fig8(const Context& context);
void fig11(const Context& context);
void fig14(const Context& context);
void fig16(const Context& context);
void fig17(const Context& context);
void fig18(const Context& context);

}  // namespace c3rt::cli::reproduce
