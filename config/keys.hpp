#pragma once
// Which keys the readers ask for: the reference of all keys follows from the code that reads them.
#include <map>
#include <string>
#include <vector>

namespace c3rt::config {

/// A key as its reader asks for it.
struct Key {
  std::vector<std::string> expected;  // "a number in [0, 1]"; several where readers differ
  bool optional = false;              // it may be left out
  std::string missing;                // what then stands in its place; empty: see the docs
};

/// While it lives, it hears what all sections of its thread are asked for.
class KeyListener {
 public:
  KeyListener();
  ~KeyListener();
  KeyListener(const KeyListener&) = delete;
  KeyListener& operator=(const KeyListener&) = delete;

  /// By path; an item of a list, whichever it is, is "*": "plant.objects.*.mass_kg".
  const std::map<std::string, Key>& keys() const { return keys_; }

 private:
  friend void note_key(const std::string& path, const std::string& expected);
  friend void note_optional(const std::string& path);
  friend void note_missing(const std::string& path, const std::string& expected,
                           const std::string& missing);
  Key& at(const std::string& path);

  std::map<std::string, Key> keys_;
  KeyListener* before_;
};

/// For readers: a key is asked for.
void note_key(const std::string& path, const std::string& expected);
/// A reader looks whether a key is there.
void note_optional(const std::string& path);
/// A key is left out, and this stands in its place.
void note_missing(const std::string& path, const std::string& expected, const std::string& missing);

}  // namespace c3rt::config
