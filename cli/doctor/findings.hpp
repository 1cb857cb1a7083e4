#pragma once
// From facts to findings: what is well, what is not, and what to do about it.
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/doctor/facts.hpp"

namespace c3rt::cli::doctor {

enum class Verdict { kOk, kWarning, kProblem };
/// "ok", "warning", "problem"
const char* name_of(Verdict verdict);

struct Finding {
  std::string group;  // "processes", "rights", "machine", "DDS", "folders", "programs"
  std::string about;  // "plant", "SCHED_FIFO"
  Verdict verdict = Verdict::kOk;
  std::string said;    // what is so
  std::string advice;  // one sentence with the command; empty where nothing is to be done
};

/// In the order in which a person reads them. A process is a problem where others of its instance
/// run and it does not; where nothing runs that is a warning.
std::vector<Finding> findings(const Facts& facts);

int count(const std::vector<Finding>& all, Verdict verdict);

/// For the terminal, by groups.
std::string text(const Facts& facts, const std::vector<Finding>& all);
nlohmann::ordered_json to_json(const Facts& facts, const std::vector<Finding>& all);

}  // namespace c3rt::cli::doctor
