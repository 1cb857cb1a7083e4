#include "cli/report/gnuplot.hpp"

#include <fstream>

#include <fmt/format.h>

#include "cli/program.hpp"

namespace c3rt::cli::gnuplot {
namespace {

constexpr double kPatience = 20.0;  // for one picture [s]

/// A PNG ends with this chunk; on a full disk it does not, and gnuplot says nothing.
bool is_whole(const std::filesystem::path& png) {
  std::ifstream stream(png, std::ios::binary);
  char end[8] = "";
  stream.seekg(-8, std::ios::end);
  return stream.read(end, sizeof end) && std::string(end, 4) == "IEND";
}

/// Why gnuplot cannot be used at all; empty while it can.
std::string& unusable() {
  static std::string reason;
  return reason;
}

std::string first_line(const std::string& text) {
  std::size_t begin = 0, end = 0;
  for (; begin < text.size(); begin = end + 1) {
    end = std::min(text.find('\n', begin), text.size());
    if (text.find_first_not_of(" \t^", begin) < end) break;
  }
  return begin < text.size() ? text.substr(begin, end - begin) : "";
}

}  // namespace

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '\n') {
      result += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

std::string terminal(int width, int height) {
  return fmt::format(
      "set terminal pngcairo size {},{} font 'DejaVu Sans,11' background 'white'\n"
      "set encoding utf8\nset border lw 0.8\nset tics nomirror out\nset grid lc rgb "
      "'#e4e4e4' lw 0.6\n",
      width, height);
}

std::string draw(const std::filesystem::path& file, const std::string& script) {
  if (!unusable().empty()) return unusable();
  const std::filesystem::path part = file.string() + ".part";
  const ProgramEnd end =
      run_program({"gnuplot"}, "set output " + quoted(part.string()) + "\n" + script, kPatience);
  std::error_code error;
  std::string reason;
  if (!end.ok()) {
    reason = end.reason;
    if (const std::string said = first_line(end.output); !said.empty()) reason += ": " + said;
    const bool useless =
        end.kind == ProgramEnd::Kind::kNotFound || end.kind == ProgramEnd::Kind::kTimedOut;
    if (useless) unusable() = reason;
  } else if (!is_whole(part)) {
    reason = "could not write the file";
  } else {
    std::filesystem::rename(part, file, error);
    if (error) reason = "drew it, but it could not be moved: " + error.message();
  }
  if (!reason.empty()) std::filesystem::remove(part, error);
  return reason;
}

std::string missing(const std::string& pictures, const std::string& reason) {
  return reason.empty() ? "" : "no " + pictures + ": gnuplot (package gnuplot-nox) " + reason;
}

}  // namespace c3rt::cli::gnuplot
