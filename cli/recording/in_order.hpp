#pragma once
// A recording in the order of time. In the file samples stand as they were taken off the bus: topic
// by topic, some milliseconds of each at once.
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "cli/recording/listener.hpp"

namespace c3rt::cli {

/// Whether the times of a topic's samples are those of its session's clock. A client's may be
/// another one's, and the words of a process may be far older than the recording: of these the
/// place in the file counts.
constexpr bool keeps_time(const wire::Topic& topic) {
  return topic.qos == wire::Qos::kStream || topic.qos == wire::Qos::kReport ||
         topic.qos == wire::Qos::kPlan;
}

/// Puts samples in order on their way from a recording to a listener: those of one topic stay in
/// theirs, those of equal times come in the order of the table, a plan before how it came about.
class InOrder final : public Listener {
 public:
  /// Samples this far out of order come into order [ns].
  static constexpr std::int64_t kDisorder_ns = 2'000'000'000;
  /// Added to the times of a topic, by place in the table [ns].
  using Shifts = std::array<std::int64_t, wire::table::kCount>;

  /// @param begin_ns time of what stands in the file before anything that keeps time
  InOrder(TimedListener& to, std::int64_t begin_ns, const Shifts& shifts = {});

  /// The file has ended: the rest is heard.
  void finish();

#define C3RT_TOPIC(Type, ...) void hear(const wire::Type& sample) override;
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  bool has_enough() const override { return to_.has_enough(); }

 private:
  template <typename T>
  void put(const T& sample);
  void release();  // the first that waits

  TimedListener& to_;
  const Shifts shifts_;
  Shifts last_;             // by topic: the time of its newest sample
  std::int64_t newest_ns_;  // of all
  std::int64_t heard_ns_;
  std::multimap<std::pair<std::int64_t, std::size_t>, std::function<void()>>
      waiting_;  // by time and place
};

}  // namespace c3rt::cli
