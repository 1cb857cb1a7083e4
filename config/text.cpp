#include "config/text.hpp"

#include <algorithm>

#include "controller/base/words.hpp"

namespace c3rt::config {
namespace {

constexpr std::size_t kLongestName = 64;

/// Bytes of the UTF-8 letter that begins here; 0 if it is none, or a control character.
std::size_t letter_length(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(at);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const std::size_t length = first >= 0xf0 && first < 0xf5   ? 4
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xc2 && first < 0xe0 ? 2
                                                             : 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xc0U) != 0x80U) return 0;
  }
  // U+0080 to U+009F are control characters as well
  if (length == 2 && first == 0xc2 && byte(at + 1) < 0xa0U) return 0;
  return length;
}

}  // namespace

std::string printable(const std::string& text, std::size_t longest) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    if (shown.size() >= longest) return shown + "…";
    const std::size_t length = letter_length(text, at);
    if (length > 0) {
      shown.append(text, at, length);
      at += length;
      continue;
    }
    shown += base::words("\\x%02x", static_cast<unsigned char>(text[at]));
    ++at;
  }
  return shown;
}

bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= kLongestName &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-';
         });
}

std::string text_of(double value) { return base::words("%g", value); }

}  // namespace c3rt::config
