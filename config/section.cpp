#include "config/section.hpp"

#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "config/read_file.hpp"

namespace c3rt::config {

struct Section::Node {
  YAML::Node yaml;
  std::string file;
  std::string path;  // "planner.admm", empty at the root
  std::set<std::string> read;
  std::vector<std::shared_ptr<Node>> children;

  std::string key_path(const std::string& key) const {
    return path.empty() ? key : path + "." + key;
  }
};

namespace {

// a value that came by --set has no line in the file; the tag remembers where it is from
const char* const kOverrideTag = "!set";

std::string where(const std::string& file, const YAML::Node& node) {
  if (node.Tag() == kOverrideTag) return file + " with --set";
  return file + ":" + std::to_string(node.Mark().line + 1);
}

std::string shortened(double value) {
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

std::string range_text(Range allowed) {
  return "[" + shortened(allowed.min) + ", " + shortened(allowed.max) + "]";
}

std::string content(const YAML::Node& node) {
  if (node.IsScalar()) return "\"" + printable(node.Scalar()) + "\"";
  if (node.IsSequence()) return "a list of " + std::to_string(node.size());
  if (node.IsMap()) return "a mapping";
  return "nothing";
}

// YAML reads 1e-3 but not every number that a person writes; std::stod with a full match is the
// rule here.
bool to_number(const YAML::Node& node, double& value) {
  if (!node.IsScalar()) return false;
  const std::string& text = node.Scalar();
  try {
    std::size_t used = 0;
    value = std::stod(text, &used);
    return used == text.size() && std::isfinite(value);
  } catch (const std::logic_error&) {
    return false;
  }
}

// the largest of the shipped scenarios has 7 kB, one with a path of 1000 points 25 kB
constexpr std::size_t kMaxBytes = 256 * 1024, kLongestText = 1000;
constexpr int kMaxDepth = 32, kMaxAliases = 100, kMaxNodes = 50000;

/// Refuses while it reads what no scenario needs, before anything is built from it.
class Limits : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { node(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    node(mark);
    if (++aliases_ > kMaxAliases) refuse(mark, "aliases", kMaxAliases);
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
  [[noreturn]] static void refuse(const YAML::Mark& mark, const char* what, int most) {
    throw YAML::ParserException(mark, "expected at most " + std::to_string(most) + " " + what);
  }
  void node(const YAML::Mark& mark) {
    if (++nodes_ > kMaxNodes) refuse(mark, "values", kMaxNodes);
  }
  void enter(const YAML::Mark& mark) {
    node(mark);
    if (++depth_ > kMaxDepth) refuse(mark, "levels", kMaxDepth);
  }
  int depth_ = 0, aliases_ = 0, nodes_ = 0;
};

/// @throws YAML::Exception
YAML::Node load_yaml(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Limits limits;
  parser.HandleNextDocument(limits);
  return YAML::Load(text);
}

void apply_override(YAML::Node& root, const std::string& file, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError("--set " + text +
                      ": expected key=value, for example --set planner.rate_hz=75");
  const std::string path = text.substr(0, equals);
  YAML::Node value;
  try {
    value = load_yaml(text.substr(equals + 1));
  } catch (const YAML::Exception& error) {
    throw ConfigError("--set " + text + ": the value is not YAML: " + error.msg);
  }
  value.SetTag(kOverrideTag);
  std::vector<YAML::Node> chain{root};
  std::string key;
  std::istringstream parts(path);
  std::vector<std::string> keys;
  while (std::getline(parts, key, '.')) keys.push_back(key);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const YAML::Node& parent = chain.back();
    YAML::Node child;
    if (parent.IsMap()) {
      for (const auto& entry : parent)
        if (entry.first.Scalar() == keys[i]) child.reset(entry.second);
    } else if (parent.IsSequence() && !keys[i].empty() &&
               keys[i].find_first_not_of("0123456789") == std::string::npos && keys[i].size() < 6 &&
               std::stoul(keys[i]) < parent.size()) {
      child.reset(parent[std::stoul(keys[i])]);
    } else {
      throw ConfigError("--set " + path + ": no such key in " + file);
    }
    if (!child.IsDefined() || child.IsNull())
      throw ConfigError("--set " + path + ": no such key in " + file);
    chain.push_back(child);
  }
  YAML::Node parent = chain[chain.size() - 2];
  if (parent.IsMap()) {
    parent[keys.back()] = value;
  } else {
    parent[std::stoul(keys.back())] = value;
  }
}

}  // namespace

void Section::fail(const std::string& key, const std::string& expected,
                   const std::string& got) const {
  const YAML::Node child = node_->yaml[key];
  throw ConfigError(where(node_->file, child.IsDefined() ? child : node_->yaml) + ": " +
                    node_->key_path(key) + ": expected " + expected + ", got " + got);
}

bool Section::has(const std::string& key) const { return node_->yaml[key].IsDefined(); }

namespace {
// Marks the key as read and gives its node; a missing key is an error that names it.
template <typename N>
YAML::Node require(N& node, const std::string& key) {
  node.read.insert(key);
  const YAML::Node child = node.yaml[key];
  if (!child.IsDefined() || child.IsNull())
    throw ConfigError(where(node.file, node.yaml) + ": " + node.key_path(key) + ": missing");
  return child;
}
}  // namespace

double Section::number(const std::string& key, Range allowed) {
  const YAML::Node child = require(*node_, key);
  double value = 0.0;
  if (!to_number(child, value) || value < allowed.min || value > allowed.max)
    fail(key, "a number in " + range_text(allowed), content(child));
  return value;
}

double Section::number(const std::string& key, Range allowed, double missing) {
  return has(key) ? number(key, allowed) : missing;
}

int Section::integer(const std::string& key, Range allowed) {
  const YAML::Node child = require(*node_, key);
  double value = 0.0;
  if (!to_number(child, value) || value != std::floor(value) || value < allowed.min ||
      value > allowed.max)
    fail(key, "an integer in " + range_text(allowed), content(child));
  return static_cast<int>(value);
}

bool Section::boolean(const std::string& key) {
  const YAML::Node child = require(*node_, key);
  if (child.IsScalar() && child.Scalar() == "true") return true;
  if (child.IsScalar() && child.Scalar() == "false") return false;
  fail(key, "true or false", content(child));
}

std::string Section::text(const std::string& key) {
  const YAML::Node child = require(*node_, key);
  if (!child.IsScalar()) fail(key, "a text", content(child));
  const std::string& value = child.Scalar();
  if (value.size() > kLongestText)
    fail(key, "a text of at most " + std::to_string(kLongestText) + " bytes",
         std::to_string(value.size()));
  if (printable(value, kLongestText) != value)
    fail(key, "a text without control characters", content(child));
  return value;
}

std::string Section::name(const std::string& key) {
  const YAML::Node child = require(*node_, key);
  if (!child.IsScalar() || !is_name(child.Scalar()))
    fail(key, "1 to 64 letters, digits, _ and -", content(child));
  return child.Scalar();
}

Eigen::VectorXd Section::numbers(const std::string& key, int size, Range allowed) {
  return numbers(key, size, size, allowed);
}

Eigen::VectorXd Section::limits(const std::string& key, int size) {
  const YAML::Node child = require(*node_, key);
  const std::string expected = "a list of " + std::to_string(size) + " numbers, .inf or -.inf";
  if (!child.IsSequence() || static_cast<int>(child.size()) != size)
    fail(key, expected, content(child));
  Eigen::VectorXd values(size);
  for (std::size_t i = 0; i < child.size(); ++i) {
    double& value = values[static_cast<Eigen::Index>(i)];
    const std::string text = child[i].IsScalar() ? child[i].Scalar() : "";
    if (text == ".inf") {
      value = std::numeric_limits<double>::infinity();
    } else if (text == "-.inf") {
      value = -std::numeric_limits<double>::infinity();
    } else if (!to_number(child[i], value)) {
      fail(key, expected, content(child[i]) + " at place " + std::to_string(i + 1));
    }
  }
  return values;
}

Eigen::VectorXd Section::numbers(const std::string& key, int min_size, int max_size,
                                 Range allowed) {
  const YAML::Node child = require(*node_, key);
  const std::string sizes = min_size == max_size
                                ? std::to_string(min_size)
                                : std::to_string(min_size) + " to " + std::to_string(max_size);
  const std::string expected = "a list of " + sizes + " numbers in " + range_text(allowed);
  if (!child.IsSequence() || static_cast<int>(child.size()) < min_size ||
      static_cast<int>(child.size()) > max_size)
    fail(key, expected, content(child));
  Eigen::VectorXd values(static_cast<Eigen::Index>(child.size()));
  for (std::size_t i = 0; i < child.size(); ++i) {
    double value = 0.0;
    if (!to_number(child[i], value) || value < allowed.min || value > allowed.max)
      fail(key, expected, content(child[i]) + " at place " + std::to_string(i + 1));
    values[static_cast<Eigen::Index>(i)] = value;
  }
  return values;
}

Eigen::VectorXd Section::one_or_each(const std::string& key, int size, Range allowed) {
  const YAML::Node child = require(*node_, key);
  if (child.IsSequence()) return numbers(key, size, allowed);
  double value = 0.0;
  if (!to_number(child, value) || value < allowed.min || value > allowed.max)
    fail(key,
         "a number in " + range_text(allowed) + ", or a list of " + std::to_string(size) +
             " of them",
         content(child));
  return Eigen::VectorXd::Constant(size, value);
}

Eigen::MatrixXd Section::rows(const std::string& key, int min_rows, int max_rows, int columns,
                              Range allowed) {
  const YAML::Node child = require(*node_, key);
  const std::string expected = "a list of " + std::to_string(min_rows) + " to " +
                               std::to_string(max_rows) + " lists of " + std::to_string(columns) +
                               " numbers in " + range_text(allowed);
  if (!child.IsSequence() || static_cast<int>(child.size()) < min_rows ||
      static_cast<int>(child.size()) > max_rows)
    fail(key, expected, content(child));
  Eigen::MatrixXd values(static_cast<Eigen::Index>(child.size()), columns);
  for (std::size_t i = 0; i < child.size(); ++i) {
    const YAML::Node row = child[i];
    bool fits = row.IsSequence() && static_cast<int>(row.size()) == columns;
    for (std::size_t j = 0; fits && j < row.size(); ++j) {
      double& value = values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      fits = to_number(row[j], value) && value >= allowed.min && value <= allowed.max;
    }
    if (!fits) fail(key, expected, content(row) + " at place " + std::to_string(i + 1));
  }
  return values;
}

Section Section::section(const std::string& key) {
  const YAML::Node child = require(*node_, key);
  if (!child.IsMap()) fail(key, "a mapping", content(child));
  Section result;
  result.node_ = std::make_shared<Node>();
  result.node_->yaml.reset(child);
  result.node_->file = node_->file;
  result.node_->path = node_->key_path(key);
  node_->children.push_back(result.node_);
  return result;
}

std::vector<Section> Section::list(const std::string& key, int min_size, int max_size) {
  const YAML::Node child = require(*node_, key);
  const std::string expected =
      "a list of " + std::to_string(min_size) + " to " + std::to_string(max_size) + " mappings";
  if (!child.IsSequence() || static_cast<int>(child.size()) < min_size ||
      static_cast<int>(child.size()) > max_size)
    fail(key, expected, content(child));
  std::vector<Section> result;
  for (std::size_t i = 0; i < child.size(); ++i) {
    if (!child[i].IsMap())
      fail(key, expected, content(child[i]) + " at place " + std::to_string(i + 1));
    Section item;
    item.node_ = std::make_shared<Node>();
    item.node_->yaml.reset(child[i]);
    item.node_->file = node_->file;
    item.node_->path = node_->key_path(key) + "." + std::to_string(i);
    node_->children.push_back(item.node_);
    result.push_back(item);
  }
  return result;
}

namespace {
template <typename N>
void refuse_unread(const N& node) {
  std::set<std::string> seen;
  for (const auto& entry : node.yaml) {
    const std::string key = entry.first.Scalar();
    if (!seen.insert(key).second)
      throw ConfigError(where(node.file, entry.first) + ": " + node.key_path(key) +
                        ": given twice");
    if (node.read.count(key) == 0)
      throw ConfigError(where(node.file, entry.first) + ": " + node.key_path(key) +
                        ": unknown key");
  }
  for (const auto& child : node.children) refuse_unread(*child);
}
}  // namespace

void Section::finish() const { refuse_unread(*node_); }

Section Document::parse(const std::string& text, const std::string& name,
                        const std::vector<std::string>& overrides) {
  YAML::Node root;
  try {
    root = load_yaml(text);
  } catch (const YAML::Exception& error) {
    throw ConfigError(name + ":" + std::to_string(error.mark.line + 1) +
                      ": not YAML: " + error.msg);
  }
  if (!root.IsMap())
    throw ConfigError(name + ": expected a mapping of sections at the top, got " + content(root));
  for (const std::string& override_text : overrides) apply_override(root, name, override_text);
  Section section;
  section.node_ = std::make_shared<Section::Node>();
  section.node_->yaml.reset(root);
  section.node_->file = name;
  return section;
}

Section Document::load(const std::string& path, const std::vector<std::string>& overrides) {
  return parse(read_file(path, "a scenario", kMaxBytes), path, overrides);
}

}  // namespace c3rt::config
