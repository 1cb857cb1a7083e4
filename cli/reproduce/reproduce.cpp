#include "cli/reproduce/reproduce.hpp"

#include <map>
#include <set>

#include <fmt/format.h>

#include "cli/evaluation.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "cli/program.hpp"
#include "cli/reproduce/context.hpp"

namespace c3rt::cli::reproduce {
namespace {

const std::map<std::string, void (*)(const Context&)> kTargets{{"comparison", comparison},
                                                               {"fig11", fig11},
                                                               {"fig14", fig14},
                                                               {"fig16", fig16},
                                                               {"fig17", fig17},
                                                               {"fig18", fig18},
                                                               {"fig3", fig3},
                                                               {"fig5", fig5},
                                                               {"fig7", fig7},
                                                               {"fig8", fig8},
                                                               {"table1", table1},
                                                               {"table2", table2},
                                                               {"table3", table3}};

/// Those that are made in the Python package: of runs alone.
const std::set<std::string> kInPython{"push_anything"};

[[noreturn]] void become_evaluation(const Settings& settings) {
  const ordered_json order{{"program", (binary_directory() / "c3rt").string()},
                           {"what", settings.what},
                           {"out", settings.out},
                           {"quick", settings.quick},
                           {"fresh", settings.fresh},
                           {"seeds", settings.seeds}};
  become_program(evaluation_words("c3rt reproduce", {}, "reproduce", order));
}

}  // namespace

std::vector<std::string> names() {
  std::set<std::string> all = kInPython;
  for (const auto& [name, target] : kTargets) all.insert(name);
  return {all.begin(), all.end()};
}

int reproduce(const Settings& settings, const Stop& stop) {
  if (kInPython.count(settings.what) != 0) become_evaluation(settings);
  const auto target = kTargets.find(settings.what);
  if (target == kTargets.end()) {
    std::string known;
    for (const std::string& name : names()) known += (known.empty() ? "" : ", ") + name;
    throw UsageError("\"" + settings.what + "\": expected one of " + known);
  }
  const Context context(settings, stop);
  try {
    target->second(context);
  } catch (const Interrupted&) {
    fmt::print(stderr,
               "interrupted; what was finished is kept, and the same command goes on from there\n");
    return kCriterionFailed;
  } catch (const NoRuns& failure) {
    return failure.status;
  }
  return kDone;
}

}  // namespace c3rt::cli::reproduce
