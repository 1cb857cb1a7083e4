#include "config/read_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "config/config_error.hpp"

namespace c3rt::config {

std::string read_file(const std::string& path, const std::string& what, std::size_t max_bytes) {
  const auto refuse = [&](const std::string& expected, const std::string& got) {
    throw ConfigError(path + ": expected " + expected + ", got " + got);
  };
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) refuse(what + " file", "a folder");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse("a file that can be read", std::strerror(errno));
  std::string text;
  // bit by bit: what is no file need not end, nor tell its size
  for (char part[1 << 16]; file.read(part, sizeof part), file.gcount() > 0;) {
    text.append(part, static_cast<std::size_t>(file.gcount()));
    if (text.size() > max_bytes) refuse("at most " + std::to_string(max_bytes) + " bytes", "more");
  }
  if (file.bad()) refuse("a file that can be read", std::strerror(errno));
  if (text.empty()) refuse(what, "an empty file");
  return text;
}

}  // namespace c3rt::config
