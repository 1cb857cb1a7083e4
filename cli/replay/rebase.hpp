#pragma once
// A recorded sample as if it were made now.
#include <cstdint>
#include <type_traits>

#include "idl/topics.hpp"

namespace c3rt::cli::replay {

/// Moves every instant of a sample: its own to `at_ns`, all others by the same, their distances to
/// it divided by `rate`. 0 stays: it means "none".
class Rebase {
 public:
  Rebase(std::int64_t from_ns, std::int64_t at_ns, double rate)
      : from_ns_(from_ns), at_ns_(at_ns), rate_(rate) {}

  template <typename T>
  void operator()(T& value) {
    if constexpr (std::is_array_v<T>) {
      if constexpr (std::is_class_v<std::remove_extent_t<T>>)
        for (auto& element : value) (*this)(element);
    } else if constexpr (std::is_class_v<T>) {
      wire::visit_in_order(value, *this);
    } else if constexpr (std::is_same_v<T, std::int64_t>) {
      // every `long long` of the contract is an instant
      if (value != 0)
        value = at_ns_ + static_cast<std::int64_t>(static_cast<double>(value - from_ns_) / rate_);
    }
  }

 private:
  std::int64_t from_ns_, at_ns_;
  double rate_;
};

}  // namespace c3rt::cli::replay
