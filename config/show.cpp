#include "config/show.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <set>

#include "config/extends.hpp"
#include "config/text.hpp"
#include "controller/base/words.hpp"

namespace c3rt::config {
namespace {

constexpr std::size_t kCommentColumn = 56;

void collect_files(const Tree& tree, std::set<std::string>& files) {
  files.insert(*tree.place.file);
  for (const Tree& item : tree.list) collect_files(item, files);
  for (const Entry& entry : tree.map) collect_files(entry.value, files);
}

/// The names of files as they are shown: without their folders where that tells them apart.
std::map<std::string, std::string> short_names(const Tree& tree) {
  std::set<std::string> files;
  collect_files(tree, files);
  std::map<std::string, int> count;
  const auto last_part = [](const std::string& file) {
    return std::filesystem::path(file).filename().string();
  };
  for (const std::string& file : files) ++count[last_part(file)];
  std::map<std::string, std::string> names;
  for (const std::string& file : files)
    names[file] = count[last_part(file)] == 1 ? last_part(file) : file;
  return names;
}

/// Plain where YAML reads it as the same text, else between quotes.
std::string scalar(const std::string& text) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '+' || c == '-';
  };
  const bool plain =
      std::all_of(text.begin(), text.end(), is_plain) &&
      std::any_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) != 0; });
  if (plain && text != "null" && text != "Null" && text != "NULL") return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) {
      quoted += c;
      continue;
    }
    quoted += base::words("\\x%02x", static_cast<unsigned char>(c));
  }
  return quoted + "\"";
}

/// On one line.
std::string flow(const Tree& tree) {
  std::string text;
  switch (tree.kind) {
    case Tree::Kind::kNothing:
      return "~";
    case Tree::Kind::kScalar:
      return scalar(tree.scalar);
    case Tree::Kind::kList:
      for (const Tree& item : tree.list) text += (text.empty() ? "" : ", ") + flow(item);
      return "[" + text + "]";
    case Tree::Kind::kMap:
      break;
  }
  for (const Entry& entry : tree.map)
    text += (text.empty() ? "" : ", ") + scalar(entry.key) + ": " + flow(entry.value);
  return "{" + text + "}";
}

class Shower {
 public:
  Shower(const Tree& tree, Comments comments) : comments_(comments), names_(short_names(tree)) {}

  std::string text() const { return text_; }

  void add(const Tree& map, const std::string& indent) {
    for (const Entry& entry : map.map) {
      const std::string key = indent + scalar(entry.key) + ":";
      const Tree& value = entry.value;
      const bool is_deep = value.is_list() &&
                           std::any_of(value.list.begin(), value.list.end(), [](const Tree& item) {
                             return item.is_list() || item.is_map();
                           });
      if (value.is_map() && !value.map.empty()) {
        text_ += key + "\n";
        add(value, indent + "  ");
      } else if (is_deep) {
        text_ += key + "\n";
        for (const Tree& item : value.list) line(indent + "  - " + flow(item), item.place);
      } else {
        line(key + " " + flow(value), value.place);
      }
    }
  }

 private:
  void line(std::string text, const Place& place) {
    if (comments_ == Comments::kPlaces) {
      text.resize(std::max(kCommentColumn, text.size() + 1), ' ');
      text += place.line > 0
                  ? "# " + printable(names_.at(*place.file)) + ":" + std::to_string(place.line)
                  : "# --set";
    }
    text_ += text + "\n";
  }

  Comments comments_;
  std::map<std::string, std::string> names_;
  std::string text_;
};

}  // namespace

std::string show(const Tree& tree, Comments comments) {
  if (!tree.is_map()) return flow(tree) + "\n";
  Shower shower(tree, comments);
  shower.add(tree, "");
  return shower.text();
}

std::string whole_scenario(const std::string& path) {
  return show(load_composed(path), Comments::kNone);
}

}  // namespace c3rt::config
