#pragma once
// The recorded inputs of one process given to a fresh one, and its answers beside the recorded
// ones.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cli/recording/in_order.hpp"
#include "cli/replay/overview.hpp"
#include "config/scenario.hpp"

namespace c3rt::cli::replay {

/// The answers on one topic.
struct TopicResult {
  std::string topic;
  std::uint64_t recorded = 0, given = 0;
  std::uint64_t same = 0;  // to the bit
};

/// How one field differs.
struct FieldResult {
  std::string topic, field;       // "plan", "knots.p_WE_m"
  std::uint64_t answers = 0;      // in which it differs
  double largest = 0.0;           // of |recorded - given|; 0 of what is no number
  std::uint64_t largest_seq = 0;  // of the recorded answer
};

struct ComparisonResult {
  std::vector<TopicResult> topics;
  /// The first that is not the same: topic, number, field, both values; empty: none.
  std::string first;
  std::vector<FieldResult> fields;  // in the order in which they came up

  std::uint64_t recorded() const;
  bool all_same() const;
};

/// Answers belong together that were made from the same state of the robot, or of vision from the
/// same exposure. Of a recording in lockstep the process acts at each multiple of its period, as
/// there. In realtime nobody knows when it acted but from its answers: it acts once for each, with
/// what the answer says that it was made from; what the recording lost is not judged.
class Comparison final : public TimedListener {
 public:
  /// @param process planner, vision or impedance
  /// @param overview outlives the comparison
  /// @throws what its node throws for a scenario that it cannot use
  Comparison(const config::Scenario& scenario, wire::Process process, std::uint64_t seed,
             const Overview& overview, bool realtime);
  ~Comparison() override;

  /// How the recording has to be put in order for it.
  const InOrder::Shifts& shifts() const;

  void at(std::int64_t time_ns) override;
#define C3RT_TOPIC(Type, ...) void hear(const wire::Type& sample) override;
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  bool has_enough() const override;

  /// After the last sample.
  const ComparisonResult& finish();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace c3rt::cli::replay
