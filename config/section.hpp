#pragma once
// YAML -> structs, strictly: unknown keys, wrong types, wrong sizes and values out of range are
// refused with file, line, key and what was expected.
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "config/config_error.hpp"

namespace c3rt::config {

struct Tree;

struct Range {
  double min;
  double max;
};

/// One mapping of a YAML file. Every key must be read once; finish() refuses what nobody read.
class Section {
 public:
  double number(const std::string& key, Range allowed);
  /// `missing` where the key is not there.
  double number(const std::string& key, Range allowed, double missing);
  int integer(const std::string& key, Range allowed);
  /// `missing` where the key is not there.
  int integer(const std::string& key, Range allowed, int missing);
  bool boolean(const std::string& key);
  /// At most 1000 bytes, without control characters.
  std::string text(const std::string& key);
  /// Letters, digits, _ and -, at most 64: it may become a path.
  std::string name(const std::string& key);
  /// A file that is there, named from the folder of the file that says so, else from that of the
  /// shipped scenarios: its absolute path.
  std::string file(const std::string& key);
  /// One or a list of `min_size`..`max_size` of them.
  std::vector<std::string> files(const std::string& key, int min_size, int max_size);
  /// A list of exactly `size` texts.
  std::vector<std::string> texts(const std::string& key, int size);
  /// A list of exactly `size` numbers.
  Eigen::VectorXd numbers(const std::string& key, int size, Range allowed);
  /// A list of `min_size`..`max_size` numbers.
  Eigen::VectorXd numbers(const std::string& key, int min_size, int max_size, Range allowed);
  /// One number for all, or a list of exactly `size` numbers.
  Eigen::VectorXd one_or_each(const std::string& key, int size, Range allowed);
  /// A list of `min_rows`..`max_rows` lists of `columns` numbers each, as (rows x columns).
  Eigen::MatrixXd rows(const std::string& key, int min_rows, int max_rows, int columns,
                       Range allowed);
  /// A list of exactly `size` numbers where .inf and -.inf stand for no limit.
  Eigen::VectorXd limits(const std::string& key, int size);
  /// The index of one of these names; the error lists them.
  int choice(const std::string& key, const std::vector<std::string>& names);
  /// One of the named choices; the error lists them.
  template <typename E>
  E choice(const std::string& key, std::initializer_list<std::pair<const char*, E>> choices) {
    std::vector<std::string> names;
    for (const auto& [name, result] : choices) names.emplace_back(name);
    return (choices.begin() + choice(key, names))->second;
  }
  bool has(const std::string& key) const;
  /// Whether a key that need not be there is. @throws ConfigError where it is `needed` and is not;
  /// `why`: "projection plus"
  bool given(const std::string& key, bool needed, const std::string& why) const;
  Section section(const std::string& key);  // a mapping below this one
  std::vector<Section> list(const std::string& key, int min_size,
                            int max_size);  // a list of mappings

  /// Refuses keys that nobody read, in this mapping and in those below that were opened.
  void finish() const;
  /// Throws ConfigError for `key` of this section.
  [[noreturn]] void fail(const std::string& key, const std::string& expected,
                         const std::string& got) const;

 private:
  friend class Document;
  /// The same at one value of a list.
  [[noreturn]] void fail_at(const Tree& at, const std::string& key, const std::string& expected,
                            const std::string& got) const;
  std::string text_at(const Tree& at, const std::string& key) const;
  std::string file_at(const Tree& at, const std::string& key) const;
  Eigen::VectorXd numbers_at(const Tree& at, const std::string& key, int min_size, int max_size,
                             Range allowed) const;
  struct Node;
  std::shared_ptr<Node> node_;
};

/// A scenario file, laid over what it extends, with overrides applied.
class Document {
 public:
  /// @param overrides "planner.admm.iterations=2": replaces a key of a mapping that is there, or
  /// adds it; one that nobody reads is refused by `finish`
  /// @throws ConfigError if the file is missing, not YAML, or an override leads nowhere
  static Section load(const std::string& path, const std::vector<std::string>& overrides = {});
  static Section parse(const std::string& text, const std::string& name,
                       const std::vector<std::string>& overrides = {});

 private:
  static Section open(Tree tree);
};

}  // namespace c3rt::config
