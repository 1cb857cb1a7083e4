#include "config/tree.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "config/config_error.hpp"

namespace c3rt::config {
namespace {

// the largest of the shipped scenarios has 600 values, one with a path of 1000 points 3,000
constexpr int kMaxDepth = 32, kMaxAliases = 100, kMaxNodes = 50000;

int values_in(const Tree& tree) {
  int count = 1;
  for (const Tree& item : tree.list) count += values_in(item);
  for (const Entry& entry : tree.map) count += 1 + values_in(entry.value);
  return count;
}

int levels_of(const Tree& tree) {
  int below = 0;
  for (const Tree& item : tree.list) below = std::max(below, levels_of(item));
  for (const Entry& entry : tree.map) below = std::max(below, levels_of(entry.value));
  return below + (tree.is_list() || tree.is_map() ? 1 : 0);
}

[[noreturn]] void refuse_more(const YAML::Mark& mark, const char* what, int most) {
  throw YAML::ParserException(mark, "expected at most " + std::to_string(most) + " " + what);
}

/// Refuses while it reads what no scenario needs, before anything is built from it.
class Limits : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { node(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    node(mark);
    if (++aliases_ > kMaxAliases) refuse_more(mark, "aliases", kMaxAliases);
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string&) override {
    node(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void node(const YAML::Mark& mark) {
    if (++nodes_ > kMaxNodes) refuse_more(mark, "values", kMaxNodes);
  }
  void enter(const YAML::Mark& mark) {
    node(mark);
    if (++depth_ > kMaxDepth) refuse_more(mark, "levels", kMaxDepth);
  }
  int depth_ = 0, aliases_ = 0, nodes_ = 0;
};

/// Builds the tree while the parser reads. An alias becomes a copy, which counts like what is
/// written.
class Builder : public YAML::EventHandler {
 public:
  /// @param in_file false: the places have no line
  Builder(const std::string& file, bool in_file)
      : file_(std::make_shared<const std::string>(file)), in_file_(in_file) {}

  Tree take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    count(mark, 1);
    add(value(Tree::Kind::kNothing, mark), anchor, mark);
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string& text) override {
    count(mark, 1);
    Tree scalar = value(Tree::Kind::kScalar, mark);
    scalar.scalar = text;
    add(std::move(scalar), anchor, mark);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto anchored = anchors_.find(anchor);
    if (anchored == anchors_.end())
      throw YAML::ParserException(mark, "an alias of the value that it stands in");
    count(mark, values_in(anchored->second));
    if (static_cast<int>(open_.size()) + levels_of(anchored->second) > kMaxDepth)
      refuse_more(mark, "levels", kMaxDepth);
    add(anchored->second, 0, mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    enter(Tree::Kind::kList, mark, anchor);
  }
  void OnSequenceEnd() override { leave(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    enter(Tree::Kind::kMap, mark, anchor);
  }
  void OnMapEnd() override { leave(); }

 private:
  /// A collection that has begun.
  struct Open {
    Tree tree;
    YAML::anchor_t anchor;
    YAML::Mark mark;
    bool has_key;  // and waits for its value
    std::string key;
    Place key_place;
    std::set<std::string> keys;
  };

  void count(const YAML::Mark& mark, int values) {
    nodes_ += values;
    if (nodes_ > kMaxNodes) refuse_more(mark, "values", kMaxNodes);
  }
  Place place(const YAML::Mark& mark) const { return {file_, in_file_ ? mark.line + 1 : 0}; }
  Tree value(Tree::Kind kind, const YAML::Mark& mark) const {
    Tree tree;
    tree.kind = kind;
    tree.place = place(mark);
    return tree;
  }
  void enter(Tree::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    count(mark, 1);
    open_.push_back({value(kind, mark), anchor, mark, false, {}, {}, {}});
  }
  void leave() {
    Open done = std::move(open_.back());
    open_.pop_back();
    add(std::move(done.tree), done.anchor, done.mark);
  }
  void add(Tree tree, YAML::anchor_t anchor, const YAML::Mark& mark) {
    if (anchor != 0) anchors_[anchor] = tree;
    if (open_.empty()) {
      root_ = std::move(tree);
      return;
    }
    Open& parent = open_.back();
    if (parent.tree.is_list()) {
      parent.tree.list.push_back(std::move(tree));
    } else if (parent.has_key) {
      parent.tree.map.push_back({parent.key, parent.key_place, std::move(tree)});
      parent.has_key = false;
    } else {
      if (!tree.is_scalar())
        throw YAML::ParserException(mark, "expected a text as key, got " + content(tree));
      parent.has_key = true;
      parent.key = tree.scalar;
      parent.key_place = place(mark);
      if (!parent.keys.insert(parent.key).second)
        throw ConfigError(parent.key_place.text() + ": " + path() + ": given twice");
    }
  }
  /// Of the newest key: "planner.c3.rho".
  std::string path() const {
    std::string text;
    for (const Open& open : open_) {
      if (!text.empty()) text += ".";
      text += open.tree.is_list() ? std::to_string(open.tree.list.size()) : open.key;
    }
    return text;
  }

  std::shared_ptr<const std::string> file_;
  bool in_file_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Tree> anchors_;
  Tree root_;
  int nodes_ = 0;
};

/// @throws YAML::Exception, ConfigError
Tree build(const std::string& text, const std::string& file, bool in_file) {
  const auto parse = [&](YAML::EventHandler& handler) {
    std::istringstream stream(text);
    YAML::Parser(stream).HandleNextDocument(handler);
  };
  Limits limits;
  parse(limits);
  Builder builder(file, in_file);
  parse(builder);
  return builder.take();
}

Tree merge(Tree base, Tree own, const std::string& path) {
  if (!base.is_map() || !own.is_map()) return own;
  base.place = own.place;
  for (Entry& entry : own.map) {
    const std::string key_path = path.empty() ? entry.key : path + "." + entry.key;
    const auto there = std::find_if(base.map.begin(), base.map.end(),
                                    [&](const Entry& e) { return e.key == entry.key; });
    if (entry.value.is_nothing()) {
      if (there == base.map.end())
        throw ConfigError(
            entry.place.text() + ": " + key_path +
            ": expected a value, or a key of what this extends to leave out, got nothing");
      base.map.erase(there);
    } else if (there == base.map.end()) {
      base.map.push_back(std::move(entry));
    } else {
      there->place = entry.place;
      there->value = merge(std::move(there->value), std::move(entry.value), key_path);
    }
  }
  return base;
}

}  // namespace

std::string Place::text() const {
  return line > 0 ? *file + ":" + std::to_string(line) : *file + " with --set";
}

const Tree* Tree::find(const std::string& key) const {
  for (const Entry& entry : map)
    if (entry.key == key) return &entry.value;
  return nullptr;
}

Tree* Tree::find(const std::string& key) {
  return const_cast<Tree*>(std::as_const(*this).find(key));
}

std::string content(const Tree& tree) {
  if (tree.is_scalar()) return "\"" + printable(tree.scalar) + "\"";
  if (tree.is_list()) return "a list of " + std::to_string(tree.list.size());
  return tree.is_map() ? "a mapping" : "nothing";
}

Tree parse_yaml(const std::string& text, const std::string& file) {
  try {
    return build(text, file, true);
  } catch (const YAML::Exception& error) {
    throw ConfigError(file + ":" + std::to_string(error.mark.line + 1) +
                      ": not YAML: " + error.msg);
  }
}

Tree parse_override(const std::string& text, const std::string& value, const std::string& file) {
  try {
    return build(value, file, false);
  } catch (const YAML::Exception& error) {
    throw ConfigError("--set " + text + ": the value is not YAML: " + error.msg);
  }
}

Tree merge(Tree base, Tree own) { return merge(std::move(base), std::move(own), ""); }

}  // namespace c3rt::config
