#include "cli/doctor/doctor.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/doctor/findings.hpp"
#include "cli/exit_status.hpp"
#include "idl/process.hpp"

namespace c3rt::cli::doctor {

int run(const Settings& settings) {
  if (!settings.json) {
    fmt::print(stderr, "looking at domain {} for about 5 s\n", settings.seat.domain);
    std::fflush(stderr);
  }
  const Facts facts = collect(settings.seat);
  if (wire::StopFlag::requested()) return kCriterionFailed;
  const std::vector<Finding> all = findings(facts);
  fmt::print("{}", settings.json ? to_json(facts, all).dump(2) + "\n" : text(facts, all));
  return count(all, Verdict::kProblem) == 0 ? kDone : kCriterionFailed;
}

}  // namespace c3rt::cli::doctor
