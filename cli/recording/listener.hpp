#pragma once
#include <cstdint>

#include "idl/topics.hpp"

namespace c3rt::cli {

/// Hears samples, of the bus in the thread that takes them or of a recording: topic by topic, each
/// in order, on the bus a plan before the commands that follow it.
class Listener {
 public:
  virtual ~Listener() = default;
#define C3RT_TOPIC(Type, ...) \
  virtual void hear(const wire::Type&) {}
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  /// Of a recording the rest is not read.
  virtual bool has_enough() const { return false; }
};

/// Hears a recording in the order of time (in_order.hpp).
class TimedListener : public Listener {
 public:
  /// Before each sample: when it is heard. It never goes back.
  virtual void at(std::int64_t time_ns) = 0;
};

}  // namespace c3rt::cli
