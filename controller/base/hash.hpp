#pragma once
// FNV-1a with 64 bits: tells two texts or two runs apart. No protection against intent.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "controller/base/words.hpp"

namespace c3rt::base {

class Hash {
 public:
  void add_bytes(const void* data, std::size_t size) noexcept {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ULL;
  }
  void add(std::string_view text) noexcept { add_bytes(text.data(), text.size()); }
  /// The bytes of a number, in the machine's order.
  template <typename T, typename = std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>>>
  void add(T value) noexcept {
    add_bytes(&value, sizeof value);
  }

  std::uint64_t value() const noexcept { return value_; }
  /// "fnv1a64:0123456789abcdef"
  std::string text() const {
    return words("fnv1a64:%016llx", static_cast<unsigned long long>(value_));
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace c3rt::base
