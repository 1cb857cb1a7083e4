#pragma once
// A file that a person names, before anybody parses it.
#include <cstddef>
#include <string>

namespace c3rt::config {

/// The file's bytes. @param what it should be, for the message: "a scenario"
/// @throws ConfigError where it is not there, no file, empty, or longer than `max_bytes`: it is not
/// read further than that
std::string read_file(const std::string& path, const std::string& what, std::size_t max_bytes);

}  // namespace c3rt::config
