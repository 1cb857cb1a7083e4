#include "config/section.hpp"

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <utility>

#include "config/directory.hpp"
#include "config/extends.hpp"
#include "config/keys.hpp"
#include "config/text.hpp"
#include "config/tree.hpp"

namespace c3rt::config {

struct Section::Node {
  std::shared_ptr<const Tree> whole;  // that holds the mapping
  const Tree* mapping;
  std::string path;  // "planner.admm", empty at the root
  std::set<std::string> read;
  std::vector<std::shared_ptr<Node>> children;

  std::string key_path(const std::string& key) const {
    return path.empty() ? key : path + "." + key;
  }
};

namespace {

std::string range_text(Range allowed) {
  return "[" + text_of(allowed.min) + ", " + text_of(allowed.max) + "]";
}

// YAML reads 1e-3 but not every number that a person writes; std::stod with a full match is the
// rule here.
bool to_number(const Tree& tree, double& value) {
  if (!tree.is_scalar()) return false;
  const std::string& text = tree.scalar;
  try {
    std::size_t used = 0;
    value = std::stod(text, &used);
    return used == text.size() && std::isfinite(value);
  } catch (const std::logic_error&) {
    return false;
  }
}

constexpr std::size_t kLongestText = 1000;

}  // namespace

void Section::fail(const std::string& key, const std::string& expected,
                   const std::string& got) const {
  const Tree* child = node_->mapping->find(key);
  fail_at(child != nullptr ? *child : *node_->mapping, key, expected, got);
}

void Section::fail_at(const Tree& at, const std::string& key, const std::string& expected,
                      const std::string& got) const {
  throw ConfigError(at.place.text() + ": " + node_->key_path(key) + ": expected " + expected +
                    ", got " + got);
}

bool Section::has(const std::string& key) const {
  note_optional(node_->key_path(key));
  return node_->mapping->find(key) != nullptr;
}

bool Section::given(const std::string& key, bool needed, const std::string& why) const {
  if (has(key)) return true;
  if (needed)
    throw ConfigError(node_->mapping->place.text() + ": " + node_->key_path(key) + ": missing, " +
                      why + " needs it");
  return false;
}

namespace {
// Marks the key as read and gives its node; a missing key is an error that names it.
template <typename N>
const Tree& require(N& node, const std::string& key, const std::string& expected) {
  node.read.insert(key);
  note_key(node.key_path(key), expected);
  const Tree* child = node.mapping->find(key);
  if (child == nullptr || child->is_nothing())
    throw ConfigError(node.mapping->place.text() + ": " + node.key_path(key) + ": missing");
  return *child;
}
}  // namespace

double Section::number(const std::string& key, Range allowed) {
  const std::string expected = "a number in " + range_text(allowed);
  const Tree& child = require(*node_, key, expected);
  double value = 0.0;
  if (!to_number(child, value) || value < allowed.min || value > allowed.max)
    fail(key, expected, content(child));
  return value;
}

double Section::number(const std::string& key, Range allowed, double missing) {
  if (has(key)) return number(key, allowed);
  note_missing(node_->key_path(key), "a number in " + range_text(allowed), text_of(missing));
  return missing;
}

int Section::integer(const std::string& key, Range allowed) {
  const std::string expected = "an integer in " + range_text(allowed);
  const Tree& child = require(*node_, key, expected);
  double value = 0.0;
  if (!to_number(child, value) || value != std::floor(value) || value < allowed.min ||
      value > allowed.max)
    fail(key, expected, content(child));
  return static_cast<int>(value);
}

int Section::integer(const std::string& key, Range allowed, int missing) {
  if (has(key)) return integer(key, allowed);
  note_missing(node_->key_path(key), "an integer in " + range_text(allowed),
               std::to_string(missing));
  return missing;
}

int Section::choice(const std::string& key, const std::vector<std::string>& names) {
  std::string expected = "one of ";
  for (std::size_t i = 0; i < names.size(); ++i) expected += (i == 0 ? "" : ", ") + names[i];
  const std::string value = text_at(require(*node_, key, expected), key);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (value == names[i]) return static_cast<int>(i);
  }
  fail(key, expected, "\"" + value + "\"");
}

bool Section::boolean(const std::string& key) {
  const std::string expected = "true or false";
  const Tree& child = require(*node_, key, expected);
  if (child.is_scalar() && child.scalar == "true") return true;
  if (child.is_scalar() && child.scalar == "false") return false;
  fail(key, expected, content(child));
}

std::string Section::text_at(const Tree& at, const std::string& key) const {
  if (!at.is_scalar()) fail_at(at, key, "a text", content(at));
  const std::string& value = at.scalar;
  if (value.size() > kLongestText)
    fail_at(at, key, "a text of at most " + std::to_string(kLongestText) + " bytes",
            std::to_string(value.size()));
  if (printable(value, kLongestText) != value)
    fail_at(at, key, "a text without control characters", content(at));
  return value;
}

std::string Section::text(const std::string& key) {
  return text_at(require(*node_, key, "a text"), key);
}

std::vector<std::string> Section::texts(const std::string& key, int size) {
  const std::string expected = "a list of " + std::to_string(size) + " texts";
  const Tree& child = require(*node_, key, expected);
  if (!child.is_list() || static_cast<int>(child.list.size()) != size)
    fail(key, expected, content(child));
  std::vector<std::string> result;
  for (const Tree& item : child.list) result.push_back(text_at(item, key));
  return result;
}

std::string Section::name(const std::string& key) {
  const std::string expected = "1 to 64 letters, digits, _ and -";
  const Tree& child = require(*node_, key, expected);
  if (!child.is_scalar() || !is_name(child.scalar)) fail(key, expected, content(child));
  return child.scalar;
}

std::string Section::file_at(const Tree& at, const std::string& key) const {
  namespace fs = std::filesystem;
  const std::string named = at.is_scalar() ? at.scalar : "";
  if (named.empty() || named.size() > kLongestText || printable(named, kLongestText) != named)
    fail_at(at, key, "the name of a file", content(at));
  const fs::path own = fs::path(*at.place.file).parent_path() / named;
  const fs::path shipped = directory() / "scenarios" / named;
  std::error_code error;
  for (const fs::path& candidate : {own, shipped}) {
    if (fs::is_regular_file(candidate, error)) return fs::weakly_canonical(candidate).string();
  }
  fail_at(at, key, "a file that is there",
          named + ", which is neither " + own.lexically_normal().string() + " nor " +
              shipped.lexically_normal().string());
}

std::string Section::file(const std::string& key) {
  return file_at(require(*node_, key, "a file"), key);
}

std::vector<std::string> Section::files(const std::string& key, int min_size, int max_size) {
  const std::string expected =
      "a list of " + std::to_string(min_size) + " to " + std::to_string(max_size) + " files";
  const Tree& child = require(*node_, key, expected);
  if (child.is_scalar() && min_size <= 1) return {file_at(child, key)};
  if (!child.is_list() || static_cast<int>(child.list.size()) < min_size ||
      static_cast<int>(child.list.size()) > max_size)
    fail(key, expected, content(child));
  std::vector<std::string> result;
  for (const Tree& item : child.list) result.push_back(file_at(item, key));
  return result;
}

Eigen::VectorXd Section::numbers(const std::string& key, int size, Range allowed) {
  return numbers(key, size, size, allowed);
}

Eigen::VectorXd Section::limits(const std::string& key, int size) {
  const std::string expected = "a list of " + std::to_string(size) + " numbers, .inf or -.inf";
  const Tree& child = require(*node_, key, expected);
  if (!child.is_list() || static_cast<int>(child.list.size()) != size)
    fail(key, expected, content(child));
  Eigen::VectorXd values(size);
  for (std::size_t i = 0; i < child.list.size(); ++i) {
    double& value = values[static_cast<Eigen::Index>(i)];
    const std::string text = child.list[i].is_scalar() ? child.list[i].scalar : "";
    if (text == ".inf") {
      value = std::numeric_limits<double>::infinity();
    } else if (text == "-.inf") {
      value = -std::numeric_limits<double>::infinity();
    } else if (!to_number(child.list[i], value)) {
      fail_at(child.list[i], key, expected,
              content(child.list[i]) + " at place " + std::to_string(i + 1));
    }
  }
  return values;
}

namespace {
std::string numbers_text(int min_size, int max_size, Range allowed) {
  const std::string sizes = min_size == max_size
                                ? std::to_string(min_size)
                                : std::to_string(min_size) + " to " + std::to_string(max_size);
  return "a list of " + sizes + " numbers in " + range_text(allowed);
}
}  // namespace

Eigen::VectorXd Section::numbers(const std::string& key, int min_size, int max_size,
                                 Range allowed) {
  const Tree& child = require(*node_, key, numbers_text(min_size, max_size, allowed));
  return numbers_at(child, key, min_size, max_size, allowed);
}

Eigen::VectorXd Section::numbers_at(const Tree& at, const std::string& key, int min_size,
                                    int max_size, Range allowed) const {
  const std::string expected = numbers_text(min_size, max_size, allowed);
  if (!at.is_list() || static_cast<int>(at.list.size()) < min_size ||
      static_cast<int>(at.list.size()) > max_size)
    fail(key, expected, content(at));
  Eigen::VectorXd values(static_cast<Eigen::Index>(at.list.size()));
  for (std::size_t i = 0; i < at.list.size(); ++i) {
    double value = 0.0;
    if (!to_number(at.list[i], value) || value < allowed.min || value > allowed.max)
      fail_at(at.list[i], key, expected,
              content(at.list[i]) + " at place " + std::to_string(i + 1));
    values[static_cast<Eigen::Index>(i)] = value;
  }
  return values;
}

Eigen::VectorXd Section::one_or_each(const std::string& key, int size, Range allowed) {
  const std::string expected =
      "a number in " + range_text(allowed) + ", or a list of " + std::to_string(size) + " of them";
  const Tree& child = require(*node_, key, expected);
  if (child.is_list()) return numbers_at(child, key, size, size, allowed);
  double value = 0.0;
  if (!to_number(child, value) || value < allowed.min || value > allowed.max)
    fail(key, expected, content(child));
  return Eigen::VectorXd::Constant(size, value);
}

Eigen::MatrixXd Section::rows(const std::string& key, int min_rows, int max_rows, int columns,
                              Range allowed) {
  const std::string expected = "a list of " + std::to_string(min_rows) + " to " +
                               std::to_string(max_rows) + " lists of " + std::to_string(columns) +
                               " numbers in " + range_text(allowed);
  const Tree& child = require(*node_, key, expected);
  if (!child.is_list() || static_cast<int>(child.list.size()) < min_rows ||
      static_cast<int>(child.list.size()) > max_rows)
    fail(key, expected, content(child));
  Eigen::MatrixXd values(static_cast<Eigen::Index>(child.list.size()), columns);
  for (std::size_t i = 0; i < child.list.size(); ++i) {
    const Tree& row = child.list[i];
    bool fits = row.is_list() && static_cast<int>(row.list.size()) == columns;
    for (std::size_t j = 0; fits && j < row.list.size(); ++j) {
      double& value = values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      fits = to_number(row.list[j], value) && value >= allowed.min && value <= allowed.max;
    }
    if (!fits) fail_at(row, key, expected, content(row) + " at place " + std::to_string(i + 1));
  }
  return values;
}

Section Section::section(const std::string& key) {
  const Tree& child = require(*node_, key, "");
  if (!child.is_map()) fail(key, "a mapping", content(child));
  Section result;
  result.node_ = std::make_shared<Node>(Node{node_->whole, &child, node_->key_path(key), {}, {}});
  node_->children.push_back(result.node_);
  return result;
}

std::vector<Section> Section::list(const std::string& key, int min_size, int max_size) {
  const std::string expected =
      "a list of " + std::to_string(min_size) + " to " + std::to_string(max_size) + " mappings";
  const Tree& child = require(*node_, key, expected);
  if (!child.is_list() || static_cast<int>(child.list.size()) < min_size ||
      static_cast<int>(child.list.size()) > max_size)
    fail(key, expected, content(child));
  std::vector<Section> result;
  for (std::size_t i = 0; i < child.list.size(); ++i) {
    if (!child.list[i].is_map())
      fail_at(child.list[i], key, expected,
              content(child.list[i]) + " at place " + std::to_string(i + 1));
    Section item;
    item.node_ = std::make_shared<Node>(
        Node{node_->whole, &child.list[i], node_->key_path(key) + "." + std::to_string(i), {}, {}});
    node_->children.push_back(item.node_);
    result.push_back(item);
  }
  return result;
}

namespace {
template <typename N>
void refuse_unread(const N& node) {
  for (const Entry& entry : node.mapping->map) {
    if (node.read.count(entry.key) == 0)
      throw ConfigError(entry.place.text() + ": " + node.key_path(entry.key) + ": unknown key");
  }
  for (const auto& child : node.children) refuse_unread(*child);
}
}  // namespace

void Section::finish() const { refuse_unread(*node_); }

Section Document::open(Tree tree) {
  const auto whole = std::make_shared<const Tree>(std::move(tree));
  Section section;
  section.node_ = std::make_shared<Section::Node>(Section::Node{whole, whole.get(), "", {}, {}});
  return section;
}

Section Document::parse(const std::string& text, const std::string& name,
                        const std::vector<std::string>& overrides) {
  return open(compose(text, name, overrides));
}

Section Document::load(const std::string& path, const std::vector<std::string>& overrides) {
  return open(load_composed(path, overrides));
}

}  // namespace c3rt::config
