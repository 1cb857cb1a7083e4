// Recordings as columns: what c3rt.log makes tables of. Of the network's library nothing is used.
#include "cli/recording/recording.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/set.h>
#include <nanobind/stl/string.h>

#include "python/src/bind.hpp"

namespace c3rt::python {

namespace nb = nanobind;

namespace {

/// What is longer, as the predicted horizon, is one column.
constexpr std::size_t kWidest = 16;

using Truth = std::uint8_t;

struct Column {
  std::string name;
  std::size_t width = 1;  // numbers of a sample
  std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::uint64_t>,
               std::vector<Truth>, std::vector<std::string>>
      values;
};

using Columns = std::vector<Column>;

/// Adds a sample, each of its fields to a column; the first sample makes the columns.
class Adding {
 public:
  explicit Adding(Columns& columns) : columns_(columns), first_(columns.empty()) {}

  template <typename T>
  void operator()(const char* name, const T& value) {
    add(name, value);
  }
  void machine_time(const char* name, double value) { add(name, value); }
  template <typename T, std::size_t n>
  void list(const char* name, const T (&values)[n], int /*used*/) {
    add(name, values);
  }

 private:
  template <typename T>
  void add(const std::string& name, const T& value) {
    if constexpr (std::is_same_v<T, wire::Header>) {
      add("time_ns", value.time_ns);
      add("seq", value.seq);
    } else if constexpr (std::is_same_v<T, wire::Origin>) {
      wire::visit_fields(value, *this);
    } else if constexpr (std::is_class_v<T>) {
      const std::string outside = prefix_;
      if (first_) prefix_ += name + "_";
      wire::visit_fields(value, *this);
      prefix_ = outside;
    } else if constexpr (std::is_array_v<T>) {
      using Element = std::remove_extent_t<T>;
      if constexpr (std::is_same_v<Element, char>) {
        column<std::string>(name).emplace_back(value);
      } else if (std::is_arithmetic_v<Element> && std::size(value) > kWidest) {
        for (const Element& element : value) put(name, element, std::size(value));
        at_ += 1;
      } else {
        std::size_t i = 0;
        for (const Element& element : value)
          add(first_ ? name + "_" + std::to_string(i++) : name, element);
      }
    } else if constexpr (std::is_enum_v<T>) {
      column<std::string>(name).emplace_back(wire::name_of(value));
    } else {
      put(name, value, 1);
      at_ += 1;
    }
  }

  /// A number into the column that is next.
  template <typename T>
  void put(const std::string& name, T value, std::size_t width) {
    using Kept = std::conditional_t<
        std::is_floating_point_v<T>, double,
        std::conditional_t<std::is_same_v<T, bool>, Truth,
                           std::conditional_t<std::is_signed_v<T>, std::int64_t, std::uint64_t>>>;
    if (first_ && columns_.size() == at_)
      columns_.push_back({prefix_ + name, width, std::vector<Kept>()});
    if constexpr (std::is_arithmetic_v<T>)
      std::get<std::vector<Kept>>(columns_[at_].values).push_back(static_cast<Kept>(value));
  }

  template <typename Kept>
  std::vector<Kept>& column(const std::string& name) {
    if (first_) columns_.push_back({prefix_ + name, 1, std::vector<Kept>()});
    return std::get<std::vector<Kept>>(columns_[at_++].values);
  }

  Columns& columns_;
  const bool first_;
  std::string prefix_;
  std::size_t at_ = 0;  // the column that is next
};

class Tables final : public cli::Listener {
 public:
  explicit Tables(std::optional<std::set<std::string>> topics) : topics_(std::move(topics)) {}
#define C3RT_TOPIC(Type, ...) \
  void hear(const wire::Type& sample) override { add(sample); }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  std::map<std::string, Columns> tables;

 private:
  template <typename T>
  void add(const T& sample) {
    const std::string name = wire::topic<T>().name;
    if (topics_ && topics_->count(name) == 0) return;
    Adding adding(tables[name]);
    wire::visit_fields(sample, adding);
  }
  std::optional<std::set<std::string>> topics_;
};

/// The memory goes to Python.
template <typename T>
nb::object array_of(std::vector<T>&& values, std::size_t width) {
  using Shown = std::conditional_t<std::is_same_v<T, Truth>, bool, T>;
  auto* kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(
      kept, [](void* memory) noexcept { delete static_cast<std::vector<T>*>(memory); });
  auto* data = reinterpret_cast<Shown*>(kept->data());
  if (width == 1) return nb::cast(nb::ndarray<nb::numpy, Shown>(data, {kept->size()}, owner));
  return nb::cast(nb::ndarray<nb::numpy, Shown>(data, {kept->size() / width, width}, owner));
}

nb::object object_of(Column& column) {
  return std::visit(
      [&](auto& values) -> nb::object {
        using Values = std::decay_t<decltype(values)>;
        if constexpr (std::is_same_v<Values, std::vector<std::string>>) {
          nb::list list;
          for (const std::string& text : values)
            list.append(nb::steal(PyUnicode_DecodeUTF8(
                text.data(), static_cast<Py_ssize_t>(text.size()), "replace")));
          return list;
        } else {
          return array_of(std::move(values), column.width);
        }
      },
      column.values);
}

nb::dict read_recording(const std::string& path,
                        const std::optional<std::set<std::string>>& topics) {
  Tables tables(topics);
  cli::Contents contents;
  {
    const nb::gil_scoped_release released;
    contents = cli::play(path, tables);
  }
  nb::dict frames, attachments, metadata, other;
  for (auto& [topic, columns] : tables.tables) {
    nb::dict frame;
    for (Column& column : columns) frame[column.name.c_str()] = object_of(column);
    frames[topic.c_str()] = frame;
  }
  for (const auto& [name, data] : contents.attachments)
    attachments[name.c_str()] = nb::bytes(data.data(), data.size());
  for (const auto& [name, texts] : contents.metadata) {
    nb::dict of_name;
    for (const auto& [key, value] : texts) of_name[key.c_str()] = value;
    metadata[name.c_str()] = of_name;
  }
  for (const auto& [topic, why] : contents.other) other[topic.c_str()] = why;
  nb::dict all;
  all["frames"] = frames;
  all["attachments"] = attachments;
  all["metadata"] = metadata;
  all["other"] = other;
  all["why"] = contents.ending.why;
  return all;
}

}  // namespace

void bind_recording(nb::module_& module) {
  module.def("read_recording", &read_recording, nb::arg("path"), nb::arg("topics").none(),
             nb::sig("def read_recording(path: str, topics: set[str] | None) -> dict[str, object]"),
             "What c3rt.log.read() is made of: frames by topic, attachments, metadata, topics of "
             "others, and why it ended early.");
}

}  // namespace c3rt::python
