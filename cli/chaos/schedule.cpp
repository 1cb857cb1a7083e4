#include "cli/chaos/schedule.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace c3rt::cli::chaos {

std::string describe(const Fault& fault) {
  std::string text = fmt::format("{} {}", fault.kind->name, fault.target);
  if (fault.amount != 0.0) text += fmt::format(" by {:.3g}", fault.amount);
  if (fault.duration > 0.0) text += fmt::format(" for {:g} s", fault.duration);
  return text;
}

Schedule::Schedule(std::vector<Choice> choices, double rate, std::uint64_t seed)
    : choices_(std::move(choices)), gap_(60.0 / rate), random_(seed) {}

std::size_t Schedule::draw(std::size_t count) {
  return static_cast<std::size_t>(random_.uniform() * static_cast<double>(count));
}

Fault Schedule::next() {
  // every number is drawn for every kind: what comes later does not depend on what this one needs
  const Choice& choice = choices_[draw(choices_.size())];
  const double gap = gap_ * (0.5 + random_.uniform());
  const double target = random_.uniform(), duration = random_.uniform(), amount = random_.uniform();
  const bool negative = random_.uniform() < 0.5;
  const auto seed = static_cast<std::uint64_t>(random_.uniform() * 0x1p53);
  const auto pick = [](const auto& all, double share) {
    return all[static_cast<std::size_t>(share * static_cast<double>(all.size()))];
  };
  const Kind& kind = *choice.kind;
  Fault fault;
  fault.number = ++count_;
  fault.kind = &kind;
  fault.target = pick(choice.targets, target);
  fault.begin = free_from_ + gap;
  if (!kind.durations.empty()) fault.duration = pick(kind.durations, duration);
  if (kind.most > 0.0) fault.amount = kind.least * std::pow(kind.most / kind.least, amount);
  if (kind.act == Act::kShiftClock && negative) fault.amount = -fault.amount;
  fault.seed = seed;
  free_from_ = fault.end();
  return fault;
}

}  // namespace c3rt::cli::chaos
