#pragma once
// Words that come from a file or a person, made fit for a terminal and for a path.
#include <cstddef>
#include <string>

namespace c3rt::config {

/// Control characters and bytes that are no UTF-8 as \xNN, what is longer than `longest` bytes cut:
/// a file's text can neither move the cursor nor fill the screen.
std::string printable(const std::string& text, std::size_t longest = 200);

/// Letters, digits, _ and -, 1 to 64 of them: safe as the name of a folder.
bool is_name(const std::string& text);

/// As short as a stream writes it: "0.005".
std::string text_of(double value);

}  // namespace c3rt::config
