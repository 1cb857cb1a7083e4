#pragma once
#include <filesystem>
#include <string>

namespace c3rt::config {

/// What is shipped: share/c3rt/config of the installed tree, seen from the program, else config/ of
/// the source tree. @throws ConfigError where neither is
std::filesystem::path directory();

/// A person means a file, not the name of a shipped one: a path with a "/", or ending in
/// `extension`.
bool is_path(const std::string& given, const std::string& extension);

}  // namespace c3rt::config
