#pragma once
// Samples that every reader lets in: with nothing in them but what they must have, and with another
// value in every field.
#include <cstdint>
#include <string>
#include <type_traits>

#include "idl/text.hpp"
#include "idl/topics.hpp"

namespace c3rt::wire::test {

/// Gives every orientation the norm that it must have.
struct Upright {
  template <typename T>
  void operator()(const char*, T& value) {
    if constexpr (std::is_same_v<T, double[4]>) {
      value[0] = 1.0;
    } else if constexpr (std::is_array_v<T>) {
      for (auto& element : value) (*this)("", element);
    } else if constexpr (std::is_class_v<T>) {
      visit_fields(value, *this);
    }
  }
  template <typename T, std::size_t n>
  void list(const char*, T (&values)[n], int) {
    (*this)("", values);
  }
  void machine_time(const char*, double&) {}
};

template <typename T>
T plain() {
  T sample{};
  Upright upright;
  visit_fields(sample, upright);
  if constexpr (std::is_same_v<T, Plan>) {
    sample.knot_count = 1;
    sample.valid_until_ns = 1'000'000'000;
  }
  if constexpr (std::is_same_v<T, Scene>) sample.object_count = 1;
  return sample;
}

/// Gives every field a value of its own.
class Numbering {
 public:
  template <typename T>
  void operator()(const char* name, T& value) {
    ++number_;
    if constexpr (std::is_same_v<T, double[4]>) {
      for (int i = 0; i < 4; ++i) value[i] = (i + number_) % 2 == 0 ? 0.5 : -0.5;
    } else if constexpr (std::is_array_v<T>) {
      if constexpr (std::is_same_v<std::remove_extent_t<T>, char>) {
        set_text(value, "text " + std::to_string(number_));
      } else {
        for (auto& element : value) (*this)(name, element);
      }
    } else if constexpr (std::is_class_v<T>) {
      visit_fields(value, *this);
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(enumerators(T{}) - 1);
    } else if constexpr (std::is_same_v<T, bool>) {
      value = true;
    } else if constexpr (std::is_same_v<T, double>) {
      value = std::string(name) == "elbow_sign" ? -1.0 : 1e-3 * number_;
    } else if constexpr (std::is_same_v<T, std::int64_t>) {
      value = 1'000'000'000 + number_;
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
      value = (static_cast<std::uint64_t>(number_) << 40) + 1;
    } else {
      value = std::string(name) == "robot" ? 0 : 2;
    }
  }
  template <typename T, std::size_t n>
  void list(const char* name, T (&values)[n], int) {
    (*this)(name, values);
  }
  void machine_time(const char* name, double& value) { (*this)(name, value); }

 private:
  int number_ = 0;
};

template <typename T>
T numbered() {
  T sample{};
  Numbering numbering;
  visit_fields(sample, numbering);
  return sample;
}

}  // namespace c3rt::wire::test
