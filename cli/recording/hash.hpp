#pragma once
// What tells two runs apart.
#include <cstdint>
#include <string>
#include <type_traits>

#include "cli/fields.hpp"
#include "controller/base/hash.hpp"

namespace c3rt::cli {

/// A hash of the values in the order in which they are named. Of a header only sequence number and
/// time count: the session is another one in each run. Times that the machine measured do not
/// count.
class HashVisitor {
 public:
  template <typename T>
  void operator()(const char*, const T& value) {
    add(value);
  }
  void machine_time(const char*, double) {}
  template <typename T, std::size_t n>
  void list(const char*, const T (&values)[n], int count) {
    for (int i = 0; i < count && i < static_cast<int>(n); ++i) add(values[i]);
  }
  std::uint64_t value() const { return hash_.value(); }
  std::string text() const { return hash_.text(); }

 private:
  template <typename T>
  void add(const T& value) {
    if constexpr (std::is_same_v<T, wire::Header>) {
      add(value.seq);
      add(value.time_ns);
    } else if constexpr (std::is_array_v<T>) {
      for (const auto& element : value) {
        add(element);
        // what stands behind the end of a text is of older samples
        if constexpr (std::is_same_v<std::remove_extent_t<T>, char>)
          if (element == '\0') break;
      }
    } else if constexpr (std::is_class_v<T>) {
      wire::visit_fields(value, *this);
    } else {
      hash_.add(value);
    }
  }
  base::Hash hash_;
};

}  // namespace c3rt::cli
