#pragma once
// Rows that a run appends for as long as it lasts, without the memory growing with it.
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <new>
#include <type_traits>
#include <utility>

namespace c3rt::cli {

/// Bytes that become more at their end: in memory while they are few; beyond that, where a folder
/// is named, in a file there that no one else sees and that ends with this.
class RowMemory {
 public:
  static constexpr std::size_t kInMemory = 1 << 20;  // bytes

  RowMemory() = default;
  explicit RowMemory(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~RowMemory() { release(); }
  RowMemory(RowMemory&& other) noexcept { swap(other); }
  RowMemory& operator=(RowMemory&& other) noexcept {
    swap(other);
    return *this;
  }

  /// Room for so many bytes in all. What is there stays, but its place may change.
  /// @throws std::runtime_error where neither memory nor the disk has room for them
  void reserve(std::size_t bytes);
  /// What lies in a file before this byte leaves the memory until it is read again.
  void let_go(std::size_t until) noexcept;

  char* data() const noexcept { return data_; }
  bool in_file() const noexcept { return file_ >= 0; }
  const std::filesystem::path& folder() const noexcept { return folder_; }
  void keep_in(const std::filesystem::path& folder) { folder_ = folder; }

 private:
  void move_to_file(std::size_t capacity);
  void extend_file(std::size_t capacity);
  void release() noexcept;
  void swap(RowMemory& other) noexcept;

  char* data_ = nullptr;
  std::size_t capacity_ = 0, let_go_ = 0;
  int file_ = -1;
  std::filesystem::path folder_;
};

/// A vector of rows on RowMemory, with as much of std::vector as a report needs.
template <typename Row>
class LongRows {
  static_assert(std::is_trivially_destructible_v<Row>);

 public:
  using value_type = Row;
  using iterator = Row*;
  using const_iterator = const Row*;

  LongRows() = default;
  /// @param folder of the file that many rows go to; empty: all stay in memory
  explicit LongRows(const std::filesystem::path& folder) : memory_(folder) {}
  LongRows(std::initializer_list<Row> rows) {
    for (const Row& row : rows) push_back(row);
  }
  LongRows(const LongRows& other) : memory_(other.memory_.folder()) {
    for (const Row& row : other) push_back(row);
  }
  LongRows(LongRows&& other) noexcept
      : memory_(std::move(other.memory_)), size_(std::exchange(other.size_, 0)) {}
  LongRows& operator=(LongRows other) noexcept {
    memory_ = std::move(other.memory_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~LongRows() = default;

  void keep_in(const std::filesystem::path& folder) { memory_.keep_in(folder); }
  bool in_file() const noexcept { return memory_.in_file(); }

  void push_back(const Row& row) {
    // it may be one of these. NOLINTNEXTLINE(performance-unnecessary-copy-initialization)
    const Row copy = row;
    memory_.reserve((size_ + 1) * sizeof(Row));
    new (begin() + size_) Row(copy);
    memory_.let_go(++size_ * sizeof(Row));
  }
  /// Memory and file are given back.
  void clear() { *this = LongRows(memory_.folder()); }

  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  iterator begin() noexcept { return reinterpret_cast<Row*>(memory_.data()); }
  iterator end() noexcept { return begin() + size_; }
  const_iterator begin() const noexcept { return reinterpret_cast<const Row*>(memory_.data()); }
  const_iterator end() const noexcept { return begin() + size_; }
  Row& operator[](std::size_t i) noexcept { return begin()[i]; }
  const Row& operator[](std::size_t i) const noexcept { return begin()[i]; }
  Row& front() noexcept { return *begin(); }
  const Row& front() const noexcept { return *begin(); }
  Row& back() noexcept { return begin()[size_ - 1]; }
  const Row& back() const noexcept { return begin()[size_ - 1]; }

 private:
  RowMemory memory_;
  std::size_t size_ = 0;
};

}  // namespace c3rt::cli
