#pragma once
// A YAML text as a tree in which every value knows where it was written.
#include <memory>
#include <string>
#include <vector>

namespace c3rt::config {

/// Where a value was written.
struct Place {
  std::shared_ptr<const std::string> file;
  int line = 0;  // from 1; 0: not in the file, it came by --set

  std::string text() const;  // "circle.yaml:12", "circle.yaml with --set"
};

struct Entry;

struct Tree {
  enum class Kind { kNothing, kScalar, kList, kMap };
  Kind kind = Kind::kNothing;
  Place place;
  std::string scalar;
  std::vector<Tree> list;
  std::vector<Entry> map;  // in the file's order, no key twice

  bool is_map() const { return kind == Kind::kMap; }
  bool is_list() const { return kind == Kind::kList; }
  bool is_scalar() const { return kind == Kind::kScalar; }
  bool is_nothing() const { return kind == Kind::kNothing; }
  /// Of this mapping, or none.
  const Tree* find(const std::string& key) const;
  Tree* find(const std::string& key);
};

struct Entry {
  std::string key;
  Place place;  // of the key
  Tree value;
};

/// What a message says that it got: "\"text\"", "a list of 3", "a mapping", "nothing".
std::string content(const Tree& tree);

/// Reads one YAML document. What no scenario needs (more than 32 levels, 50,000 values, 100
/// aliases) is refused before anything is built from it, and so is a key that is given twice.
/// @param file for messages
/// @throws ConfigError naming file and line
Tree parse_yaml(const std::string& text, const std::string& file);

/// The value of an override, "[1, 2]" of "--set a.b=[1, 2]"; its place is no line of the file.
/// @throws ConfigError
Tree parse_override(const std::string& text, const std::string& value, const std::string& file);

/// Lays `own` over `base`: mappings key by key, everything else as a whole. A key with nothing
/// ("key: ~") takes the base's key out.
/// @throws ConfigError for a key to take out that the base does not have
Tree merge(Tree base, Tree own);

}  // namespace c3rt::config
