#pragma once
// Which fault comes when. Pure: a function of the seed, the choices and the rate alone.
#include <cstdint>
#include <string>
#include <vector>

#include "cli/chaos/kinds.hpp"
#include "controller/base/random.hpp"

namespace c3rt::cli::chaos {

struct Fault {
  std::uint64_t number = 0;  // from 1
  const Kind* kind = nullptr;
  std::string target;
  double begin = 0.0, duration = 0.0;  // [s]
  double amount = 0.0;                 // as the kind has it
  std::uint64_t seed = 0;              // of what is random in it

  double end() const { return begin + duration; }
};

/// "stop planner for 1 s", "delay of state-to-planner by 0.013 for 0.2 s"
std::string describe(const Fault& fault);

/// One fault after the other: each kind is as likely as another, each of its targets, too. From one
/// fault's end to the next one's begin it is half to one and a half of the mean gap.
class Schedule {
 public:
  static constexpr double kFirst = 4.0;  // until then the task begins [s]

  /// @param rate faults in a minute of the time between them
  Schedule(std::vector<Choice> choices, double rate, std::uint64_t seed);
  Fault next();

 private:
  std::size_t draw(std::size_t count);
  const std::vector<Choice> choices_;
  const double gap_;  // mean [s]
  base::Random random_;
  std::uint64_t count_ = 0;
  double free_from_ = kFirst;  // [s]
};

}  // namespace c3rt::cli::chaos
