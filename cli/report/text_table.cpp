#include "cli/report/text_table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace c3rt::cli {
namespace {

/// Columns on a terminal: bytes that begin a UTF-8 letter.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

std::string text_table(const Rows& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    if (row.size() < 2) continue;
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::size_t missing =
          row.size() < 2 ? 0 : widths[i] - std::min(widths[i], width(row[i]));
      const std::string space(missing, ' ');
      line += i == 0 ? row[i] + space : "  " + space + row[i];
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string markdown_table(const Rows& rows) {
  std::size_t columns = 0;
  for (const auto& row : rows) columns = std::max(columns, row.size());
  std::string text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    text += "|";
    for (std::size_t j = 0; j < columns; ++j) {
      const std::string cell = j < rows[i].size() ? rows[i][j] : "";
      text += (rows[i].size() == 1 && j == 0 ? " **" + cell + "**" : " " + cell) + " |";
    }
    text += "\n";
    if (i == 0) {
      text += "|";
      for (std::size_t j = 0; j < columns; ++j) text += " --- |";
      text += "\n";
    }
  }
  return text;
}

std::string shown(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "-";
}

}  // namespace c3rt::cli
