#include "config/keys.hpp"

#include <algorithm>
#include <cctype>

namespace c3rt::config {
namespace {

thread_local KeyListener* listening = nullptr;

bool is_index(const std::string& part) {
  return !part.empty() && std::all_of(part.begin(), part.end(),
                                      [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::string without_indices(const std::string& path) {
  std::string result;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string part = path.substr(begin, end - begin);
    result += (result.empty() ? "" : ".") + (is_index(part) ? "*" : part);
    begin = end + 1;
  }
  return result;
}

}  // namespace

KeyListener::KeyListener() : before_(listening) { listening = this; }
KeyListener::~KeyListener() { listening = before_; }

Key& KeyListener::at(const std::string& path) { return keys_[without_indices(path)]; }

void note_key(const std::string& path, const std::string& expected) {
  if (listening == nullptr) return;
  std::vector<std::string>& all = listening->at(path).expected;
  if (!expected.empty() && std::find(all.begin(), all.end(), expected) == all.end())
    all.push_back(expected);
}

void note_optional(const std::string& path) {
  if (listening != nullptr) listening->at(path).optional = true;
}

void note_missing(const std::string& path, const std::string& expected,
                  const std::string& missing) {
  if (listening == nullptr) return;
  note_key(path, expected);
  listening->at(path).missing = missing;
}

}  // namespace c3rt::config
