#include "cli/reproduce/reproduce.hpp"

#include <map>

#include <fmt/format.h>

#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
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
                                                               {"push_anything", push_anything},
                                                               {"table1", table1},
                                                               {"table2", table2},
                                                               {"table3", table3}};

}  // namespace

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& [name, target] : kTargets) all.push_back(name);
  return all;
}

int reproduce(const Settings& settings, const Stop& stop) {
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
