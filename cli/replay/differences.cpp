#include "cli/replay/differences.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <unordered_map>

#include <fmt/format.h>

#include "config/text.hpp"
#include "idl/cdr.hpp"

namespace c3rt::cli::replay {
namespace {

struct Leaf {
  std::string field, text;
  double number = 0.0;
  bool is_number = false;
};

/// Every value of a sample by its name.
class Flattening {
 public:
  template <typename T>
  void operator()(const char* name, const T& value) {
    const std::size_t length = path_.size();
    path_ += (path_.empty() ? "" : ".") + std::string(name);
    add(value);
    path_.resize(length);
  }
  void machine_time(const char*, double) {}
  template <typename T, std::size_t n>
  void list(const char* name, const T (&values)[n], int count) {
    const std::size_t length = path_.size();
    path_ += (path_.empty() ? "" : ".") + std::string(name);
    for (int i = 0; i < count && i < static_cast<int>(n); ++i) element(values[i], i);
    path_.resize(length);
  }
  std::vector<Leaf> leaves;

 private:
  template <typename T>
  void element(const T& value, int i) {
    const std::size_t length = path_.size();
    path_ += fmt::format("[{}]", i);
    add(value);
    path_.resize(length);
  }
  template <typename T>
  void add(const T& value) {
    if constexpr (std::is_array_v<T>) {
      if constexpr (std::is_same_v<std::remove_extent_t<T>, char>) {
        leaves.push_back({path_, "\"" + config::printable(value, sizeof value * 4) + "\""});
      } else {
        int i = 0;
        for (const auto& each : value) element(each, i++);
      }
    } else if constexpr (std::is_enum_v<T>) {
      leaves.push_back({path_, wire::name_of(value)});
    } else if constexpr (std::is_same_v<T, bool>) {
      leaves.push_back({path_, value ? "true" : "false"});
    } else if constexpr (std::is_class_v<T>) {
      wire::visit_fields(value, *this);
    } else {
      leaves.push_back({path_, fmt::format("{}", value), static_cast<double>(value), true});
    }
  }
  std::string path_;
};

/// Without what is another one in each run.
template <typename T>
T comparable(T sample) {
  sample.header.session_id = sample.header.seq = 0;
  if constexpr (std::is_same_v<T, wire::Plan>) sample.solve_time_s = 0.0;
  if constexpr (std::is_same_v<T, wire::PlannerDebug>) sample.plan_seq = 0;
  return sample;
}

template <typename T>
std::vector<Leaf> leaves_of(const T& sample) {
  Flattening flat;
  wire::visit_fields(sample, flat);
  return std::move(flat.leaves);
}

}  // namespace

template <typename T>
std::vector<Difference> differences(const T& recorded, const T& given) {
  const T ours = comparable(recorded), theirs = comparable(given);
  wire::Bytes one, other;
  wire::to_cdr(ours, one);
  wire::to_cdr(theirs, other);
  if (one == other) return {};
  const std::vector<Leaf> before = leaves_of(ours), after = leaves_of(theirs);
  std::unordered_map<std::string_view, const Leaf*> left;
  for (const Leaf& leaf : after) left[leaf.field] = &leaf;
  std::vector<Difference> result;
  for (const Leaf& leaf : before) {
    const auto found = left.find(leaf.field);
    if (found == left.end()) {
      result.push_back({leaf.field, leaf.text, "", 0.0});
      continue;
    }
    const Leaf& now = *found->second;
    left.erase(found);
    // the shortest text that gives the same bits again: equal texts are equal numbers
    if (leaf.text == now.text) continue;
    const double amount = leaf.is_number ? std::abs(leaf.number - now.number) : 0.0;
    result.push_back({leaf.field, leaf.text, now.text, std::isfinite(amount) ? amount : 0.0});
  }
  for (const Leaf& leaf : after) {
    if (left.count(leaf.field) > 0) result.push_back({leaf.field, "", leaf.text, 0.0});
  }
  return result;
}

#define C3RT_TOPIC(Type, ...) \
  template std::vector<Difference> differences(const wire::Type&, const wire::Type&);
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

std::string without_places(const std::string& field) {
  std::string result;
  bool inside = false;
  for (const char c : field) {
    if (c == '[') inside = true;
    if (!inside) result += c;
    if (c == ']') inside = false;
  }
  return result;
}

}  // namespace c3rt::cli::replay
