#pragma once
// What a run leaves for later: one CSV file per topic, and a hash that tells two runs apart.
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "cli/fields.hpp"
#include "controller/base/hash.hpp"

namespace c3rt::cli {

/// A hash of the values in the order in which they are named. Of a header only sequence number and
/// time count: the session is another one in each run. Times that the machine measured do not
/// count.
class HashVisitor {
 public:
  void header(const wire::Header& header) {
    add(header.seq);
    add(header.time_ns);
  }
  template <typename T>
  void operator()(const char*, const T& value) {
    add(value);
  }
  void machine_time(const char*, double) {}
  template <std::size_t Columns>
  void matrix(const char*, const double (*value)[Columns], int rows, int columns) {
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < columns && j < static_cast<int>(Columns); ++j) add(value[i][j]);
    }
  }
  std::uint64_t value() const { return hash_.value(); }
  std::string text() const { return hash_.text(); }

 private:
  template <typename T>
  void add(const T& value) {
    if constexpr (std::is_array_v<T>) {
      for (const auto& element : value) add(element);
    } else {
      hash_.add(value);
    }
  }
  base::Hash hash_;
};

/// One row of numbers; `names` instead writes the head line.
class CsvVisitor {
 public:
  CsvVisitor(fmt::memory_buffer& out, bool names) : out_(out), names_(names) {}
  void header(const wire::Header& header) {
    (*this)("time_ns", header.time_ns);
    (*this)("seq", header.seq);
  }
  template <typename T>
  void operator()(const char* name, const T& value) {
    add(name, value);
  }
  void machine_time(const char* name, double value) { add(name, value); }
  /// The predicted horizon is not for a table.
  template <std::size_t Columns>
  void matrix(const char*, const double (*)[Columns], int, int) {}

 private:
  template <typename T>
  void add(const std::string& name, const T& value) {
    if constexpr (std::is_array_v<T>) {
      int i = 0;
      for (const auto& element : value)
        add(names_ ? name + "_" + std::to_string(i++) : name, element);
    } else {
      if (!first_) out_.push_back(',');
      first_ = false;
      if (names_) {
        fmt::format_to(std::back_inserter(out_), "{}", name);
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
};

/// The log of one topic: DIRECTORY/robot_state.csv for robot/state, with .part behind it until it
/// is whole. Values with nine digits, time in ns.
template <typename T>
class TopicLog {
 public:
  /// @param directory empty: the hash alone
  /// @throws std::runtime_error if the file cannot be written
  explicit TopicLog(const std::filesystem::path& directory) {
    if (directory.empty()) return;
    std::string name = wire::topic<T>().name;
    for (char& c : name) c = c == '/' ? '_' : c;
    path_ = directory / (name + ".csv");
    file_.reset(std::fopen(part().c_str(), "we"));
    if (!file_) fail();
    write(T{}, true);
  }
  /// @throws std::runtime_error where the disk has no room for it
  void add(const T& sample) {
    hash_.header(sample.header);
    visit_fields(sample, hash_);
    if (file_) write(sample, false);
  }
  std::uint64_t hash() const { return hash_.value(); }
  /// The file is whole. @throws std::runtime_error where the disk has no room for it
  void finish() {
    if (!file_) return;
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
    visitor.header(sample.header);
    visit_fields(sample, visitor);
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
  HashVisitor hash_;
};

}  // namespace c3rt::cli
