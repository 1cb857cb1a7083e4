#pragma once
// What a watched run did that it must not do: bounded, however long it goes on.
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace c3rt::cli::invariants {

/// One stretch of time in which an invariant did not hold.
struct Violation {
  std::string name;     // "torque_rate"
  std::string subject;  // the stream or process: "robot/state", "planner"
  double time;          // when it began, of the session, which is the pass's in simulated time [s]
  double value, limit;  // the worst value in that time; in the unit of the name
  std::string unit;
  std::uint64_t pass, seed;
};

/// A sentence for a person.
std::string describe(const Violation& violation);

/// Collects them. Samples that violate the same invariant less than an episode apart are one
/// violation.
class Violations {
 public:
  static constexpr double kEpisode = 1.0;        // [s]
  static constexpr std::size_t kMostKept = 200;  // the first ones; all are counted

  /// From now on they are of this pass.
  void begin_pass(std::uint64_t pass, std::uint64_t seed);
  /// @param time of the session [s]  @param episode of what is looked at seldom: longer [s]
  void add(const std::string& name, const std::string& subject, double time, double value,
           double limit, const std::string& unit, double episode = kEpisode);
  /// For a person who looks on: what began since the last call, of each invariant and subject the
  /// first of all passes.
  std::vector<Violation> take_news();

  std::uint64_t count() const noexcept { return count_; }
  const std::map<std::string, std::uint64_t>& counts() const noexcept {
    return counts_;
  }  // by name
  const std::vector<Violation>& kept() const noexcept { return kept_; }

 private:
  struct Open {
    double last;       // [s]
    std::size_t kept;  // its place in kept_; kMostKept: none
  };
  std::uint64_t pass_ = 1, seed_ = 1, count_ = 0;
  std::map<std::string, std::uint64_t> counts_;
  std::map<std::string, Open> open_;  // of this pass, by name and subject
  std::vector<Violation> kept_, news_;
  std::set<std::string> told_;  // names and subjects
};

}  // namespace c3rt::cli::invariants
