#pragma once
// Texts of samples, which have room for so many letters and no more.
#include <algorithm>
#include <cstddef>
#include <string_view>

#include "idl/topics.hpp"

namespace c3rt::wire {

/// Cuts what there is no room for; a control letter would spoil a terminal, and readers refuse it.
/// RT: no heap, no lock, no throw.
template <std::size_t size>
void set_text(char (&target)[size], std::string_view text) noexcept {
  const std::size_t length = std::min(text.size(), size - 1);
  std::transform(
      text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length), target, [](char letter) {
        return static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f ? ' ' : letter;
      });
  target[length] = '\0';
}

/// Of a plan's phases those of every planner: waiting, on the way to an object, bringing it to
/// rest, holding. Any other is of its strategy: it is at its task.
inline bool is_at_task(std::string_view phase) noexcept {
  return !phase.empty() && phase != "wait" && phase != "approach" && phase != "rest" &&
         phase != "hold";
}

}  // namespace c3rt::wire
