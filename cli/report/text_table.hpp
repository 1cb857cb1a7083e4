#pragma once
// Tables of text.
#include <string>
#include <vector>

namespace c3rt::cli {

using Rows = std::vector<std::vector<std::string>>;

/// The first column left, the others right; a row of one cell is a heading. Ends with a new line.
std::string text_table(const Rows& rows);

/// The same in Markdown; the first row is the head, a row of one cell becomes bold.
std::string markdown_table(const Rows& rows);

/// Of at most this many digits, "-" where there is none.
std::string shown(double value, int digits = 4);

}  // namespace c3rt::cli
