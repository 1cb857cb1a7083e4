#pragma once
// One table a topic, for those who have no reader of MCAP.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <fmt/format.h>

#include "cli/fields.hpp"

namespace c3rt::cli {

/// One row of cells; `names` instead writes the head line. What is in an array of structs has its
/// place in the name: knots_0_time_ns. What is longer than kWidest, as the predicted horizon, is
/// not for a table.
class CsvVisitor {
 public:
  static constexpr std::size_t kWidest = 16;

  CsvVisitor(fmt::memory_buffer& out, bool names) : out_(out), names_(names) {}
  template <typename T>
  void operator()(const char* name, const T& value) {
    add(names_ ? prefix_ + name : prefix_, value);
  }
  void machine_time(const char* name, double value) { (*this)(name, value); }
  /// Every place has its columns, used or not.
  template <typename T, std::size_t n>
  void list(const char* name, const T (&values)[n], int) {
    (*this)(name, values);
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
      if (names_) prefix_ = name + "_";
      wire::visit_fields(value, *this);
      prefix_ = outside;
    } else if constexpr (std::is_array_v<T> && !std::is_same_v<std::remove_extent_t<T>, char>) {
      if (std::size(value) > kWidest) return;
      int i = 0;
      for (const auto& element : value)
        add(names_ ? name + "_" + std::to_string(i++) : name, element);
    } else {
      if (!first_) out_.push_back(',');
      first_ = false;
      if (names_) {
        out_.append(std::string_view(name));
      } else if constexpr (std::is_array_v<T>) {  // NOLINT: a text; a comma would be another cell
        for (std::size_t i = 0; i < std::size(value) && value[i] != '\0'; ++i)
          out_.push_back(value[i] == ',' || value[i] == '"' ? ' ' : value[i]);
      } else if constexpr (std::is_enum_v<T>) {
        fmt::format_to(std::back_inserter(out_), "{}", static_cast<int>(value));
      } else if constexpr (std::is_same_v<T, bool>) {
        out_.push_back(value ? '1' : '0');
      } else if constexpr (std::is_floating_point_v<T>) {
        fmt::format_to(std::back_inserter(out_), "{:.9g}", value);
      } else {
        fmt::format_to(std::back_inserter(out_), "{}", value);
      }
    }
  }
  fmt::memory_buffer& out_;
  bool names_;
  bool first_ = true;
  std::string prefix_;  // of the names
};

/// The samples of one topic: DIRECTORY/robot_state.csv for robot/state, with .part behind it until
/// it is whole. Values with nine digits, time in ns.
template <typename T>
class TopicCsv {
 public:
  /// @throws std::runtime_error if the file cannot be written
  explicit TopicCsv(const std::filesystem::path& directory) {
    std::string name = wire::topic<T>().name;
    for (char& c : name) c = c == '/' ? '_' : c;
    path_ = directory / (name + ".csv");
    file_.reset(std::fopen(part().c_str(), "we"));
    if (!file_) fail();
    write(T{}, true);
  }
  /// @throws std::runtime_error where the disk has no room for it
  void add(const T& sample) { write(sample, false); }
  /// The file is whole. @throws std::runtime_error where the disk has no room for it
  void finish() {
    errno = 0;
    if (std::fclose(file_.release()) != 0) fail();
    std::error_code error;
    std::filesystem::rename(part(), path_, error);
    if (error) throw std::runtime_error("cannot write " + path_.string() + ": " + error.message());
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void write(const T& sample, bool names) {
    row_.clear();
    CsvVisitor visitor(row_, names);
    visit_sample(sample, visitor);
    row_.push_back('\n');
    errno = 0;
    if (std::fwrite(row_.data(), 1, row_.size(), file_.get()) != row_.size()) fail();
  }
  std::filesystem::path part() const { return path_.string() + ".part"; }
  [[noreturn]] void fail() const {
    throw std::runtime_error("cannot write " + path_.string() + ": " +
                             (errno != 0 ? std::strerror(errno) : "something was lost"));
  }
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
  fmt::memory_buffer row_;
};

}  // namespace c3rt::cli
