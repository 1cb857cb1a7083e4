#include "idl/topics.hpp"

#include <type_traits>

namespace c3rt::wire {

namespace {

constexpr int streams() {
  int count = 0;
  for (const Topic& topic : table::kTopics) count += topic.stream != kNoStream ? 1 : 0;
  return count;
}
static_assert(streams() <= c3rt_v2_TOPIC_COUNT, "a tick has room for every stream");

// fixed size: a sample is copied as bytes between threads and taken without allocation
template <typename... T>
constexpr bool all_trivially_copyable(const std::tuple<T...>*) {
  return (std::is_trivially_copyable_v<T> && ...);
}
static_assert(all_trivially_copyable(static_cast<const TopicTypes*>(nullptr)));

}  // namespace

}  // namespace c3rt::wire
