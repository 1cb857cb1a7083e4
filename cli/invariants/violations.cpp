#include "cli/invariants/violations.hpp"

#include <cmath>

#include <fmt/format.h>

namespace c3rt::cli::invariants {

std::string describe(const Violation& violation) {
  return fmt::format("{} of {} at {:.3f} s: {:.6g}{}, limit {:.6g} (pass {}, seed {})",
                     violation.name, violation.subject, violation.time, violation.value,
                     violation.unit.empty() ? "" : " " + violation.unit, violation.limit,
                     violation.pass, violation.seed);
}

void Violations::begin_pass(std::uint64_t pass, std::uint64_t seed) {
  pass_ = pass;
  seed_ = seed;
  open_.clear();
}

void Violations::add(const std::string& name, const std::string& subject, double time, double value,
                     double limit, const std::string& unit, double episode) {
  const std::string key = name + " " + subject;
  if (told_.insert(key).second)
    news_.push_back({name, subject, time, value, limit, unit, pass_, seed_});
  const auto [found, fresh] = open_.try_emplace(key, Open{time, kMostKept});
  Open& open = found->second;
  if (fresh || time - open.last > episode) {
    ++count_;
    ++counts_[name];
    open.kept = kMostKept;
    if (kept_.size() < kMostKept) {
      open.kept = kept_.size();
      kept_.push_back({name, subject, time, value, limit, unit, pass_, seed_});
    }
  } else if (open.kept < kMostKept) {
    Violation& known = kept_[open.kept];
    // the farther from its limit the worse, on whichever side
    if (std::abs(value - limit) > std::abs(known.value - known.limit)) {
      known.value = value;
      known.limit = limit;
    }
  }
  open.last = time;
}

std::vector<Violation> Violations::take_news() {
  std::vector<Violation> news;
  news.swap(news_);
  return news;
}

}  // namespace c3rt::cli::invariants
