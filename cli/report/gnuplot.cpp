#include "cli/report/gnuplot.hpp"

#include <cstdio>

#include <fmt/format.h>

namespace c3rt::cli::gnuplot {

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

std::string terminal(const std::filesystem::path& file, int width, int height) {
  return fmt::format(
      "set terminal pngcairo size {},{} font 'DejaVu Sans,11' background 'white'\n"
      "set output {}\nset encoding utf8\nset border lw 0.8\nset tics nomirror out\nset grid lc rgb "
      "'#e4e4e4' lw 0.6\n",
      width, height, quoted(file.string()));
}

bool draw(const std::string& script) {
  FILE* gnuplot = popen("gnuplot >/dev/null 2>&1", "w");
  if (gnuplot == nullptr) return false;
  const bool written = fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
  return pclose(gnuplot) == 0 && written;
}

std::string missing(const std::string& pictures) {
  return pictures.empty()
             ? ""
             : pictures + " could not be drawn: gnuplot (package gnuplot-nox) is missing or failed";
}

}  // namespace c3rt::cli::gnuplot
