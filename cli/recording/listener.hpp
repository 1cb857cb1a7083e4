#pragma once
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
};

}  // namespace c3rt::cli
