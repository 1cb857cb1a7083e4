#include "cli/evaluation.hpp"

#include <cstdlib>

#include <nlohmann/json.hpp>

#include "cli/paths.hpp"
#include "cli/program.hpp"
#include "cli/python.hpp"

namespace c3rt::cli {
namespace {

using nlohmann::ordered_json;
using Packages = std::vector<std::string>;

/// One that has the packages. @param wanted by whom, for the message
/// @throws UsageError naming which were looked at
std::string python_with(const std::string& wanted, const Packages& packages) {
  const FoundPython python = find_python(packages);
  if (python.program.empty()) throw UsageError(wanted + ": " + python.missing);
  return python.program;
}

/// Becomes `python -m c3rt.evaluation COMMAND ORDER`, with the package of this program's sources or
/// installation first in PYTHONPATH.
[[noreturn]] void become_evaluation(const std::string& python, const std::string& command,
                                    const ordered_json& order) {
  setenv("PYTHONPATH", package_path().c_str(), 1);
  // what is installed stays as it was installed
  become_program({python, "-B", "-m", "c3rt.evaluation", command, order.dump()});
}

ordered_json order_of(const EngineSettings& settings) {
  return {{"program", (binary_directory() / "c3rt").string()},
          {"duration", settings.duration ? ordered_json(*settings.duration) : ordered_json()},
          {"at_once", settings.at_once},
          {"fresh", settings.fresh},
          {"engine", settings.engine},
          {"address", settings.address}};
}

/// @param packages that are needed besides those of the engine
[[noreturn]] void become(const std::string& command, const EngineSettings& settings,
                         Packages packages, const ordered_json& order) {
  const bool on_dask = settings.engine == "dask";
  if (on_dask) packages.emplace_back("distributed");
  become_evaluation(python_with(on_dask ? "--engine dask" : "c3rt " + command, packages), command,
                    order);
}

/// One that draws where there is one; without pictures there are still the numbers.
std::string python_for_figures() {
  const FoundPython draws = find_python({"matplotlib"});
  return draws.program.empty() ? python_with("c3rt reproduce", {}) : draws.program;
}

}  // namespace

const std::vector<std::string>& reproduced() {
  static const std::vector<std::string> names{
      "comparison", "fig11", "fig14", "fig16",         "fig17",  "fig18",  "fig3",  "fig5",
      "fig7",       "fig8",  "gap",   "push_anything", "table1", "table2", "table3"};
  return names;
}

void reproduce(const ReproduceSettings& settings) {
  become_evaluation(python_for_figures(), "reproduce",
                    {{"program", (binary_directory() / "c3rt").string()},
                     {"what", settings.what},
                     {"out", settings.out},
                     {"quick", settings.quick},
                     {"fresh", settings.fresh},
                     {"seeds", settings.seeds},
                     {"miqp_limit", settings.miqp_limit}});
}

void campaign(const CampaignSettings& settings) {
  ordered_json order = order_of(settings);
  order.update({{"scenario", settings.scenario},
                {"seeds", settings.seeds},
                {"overrides", settings.overrides},
                {"out", settings.out},
                {"logs", settings.logs},
                {"pictures", settings.pictures},
                {"in_process", settings.in_process}});
  become("campaign", settings, {}, order);
}

void tune(const TuneSettings& settings) {
  ordered_json order = order_of(settings);
  order.update({{"scenario", settings.scenario},
                {"overrides", settings.overrides},
                {"search_overrides", settings.search_overrides},
                {"linear", settings.linear},
                {"log", settings.log},
                {"whole", settings.whole},
                {"minimise", settings.minimise},
                {"maximise", settings.maximise},
                {"seeds", settings.seeds},
                {"finalists", settings.finalists},
                {"final_seeds", settings.final_seeds},
                {"test_seeds", settings.test_seeds},
                {"generations", settings.generations},
                {"population", settings.population},
                {"sigma", settings.sigma},
                {"seed", settings.seed},
                {"out", settings.out}});
  become("tune", settings, {"cmaes"}, order);
}

}  // namespace c3rt::cli
