#include "cli/recording/in_order.hpp"

#include <algorithm>
#include <utility>

namespace c3rt::cli {

InOrder::InOrder(TimedListener& to, std::int64_t begin_ns, const Shifts& shifts)
    : to_(to), shifts_(shifts), newest_ns_(begin_ns), heard_ns_(begin_ns) {
  last_.fill(begin_ns);
}

template <typename T>
void InOrder::put(const T& sample) {
  constexpr std::size_t place = wire::table::PlaceOf<T>::value;
  std::int64_t time_ns = newest_ns_;
  if constexpr (keeps_time(wire::topic<T>())) time_ns = sample.header.time_ns + shifts_[place];
  time_ns = last_[place] = std::max(time_ns, last_[place]);
  newest_ns_ = std::max(newest_ns_, time_ns);
  waiting_.emplace(std::pair{time_ns, place}, [this, sample] { to_.hear(sample); });
  while (waiting_.begin()->first.first < newest_ns_ - kDisorder_ns) release();
}

void InOrder::release() {
  const auto first = waiting_.begin();
  heard_ns_ = std::max(heard_ns_, first->first.first);
  if (!to_.has_enough()) {
    to_.at(heard_ns_);
    first->second();
  }
  waiting_.erase(first);
}

void InOrder::finish() {
  while (!waiting_.empty()) release();
}

#define C3RT_TOPIC(Type, ...) \
  void InOrder::hear(const wire::Type& sample) { put(sample); }
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

}  // namespace c3rt::cli
