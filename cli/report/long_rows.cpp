#include "cli/report/long_rows.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace c3rt::cli {
namespace {

constexpr std::size_t kStep = 1 << 17;  // so much of a file stays in memory [bytes]

[[noreturn]] void fail(const std::filesystem::path& folder, int error) {
  throw std::runtime_error("no room for the time series" +
                           (folder.empty() ? std::string() : " in " + folder.string()) + ": " +
                           std::strerror(error));
}

std::size_t rounded(std::size_t bytes) {
  static const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return (bytes + page - 1) / page * page;
}

/// Without a name, so that nothing is left behind however this process ends.
int nameless_file(const std::filesystem::path& folder) {
  const int file = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0) return file;
  // a file system that has no such files
  std::string name = (folder / ".c3rt-series-XXXXXX").string();
  const int named = mkostemp(name.data(), O_CLOEXEC);
  if (named < 0) fail(folder, errno);
  unlink(name.c_str());
  return named;
}

}  // namespace

void RowMemory::reserve(std::size_t bytes) {
  if (bytes <= capacity_) return;
  if (in_file()) {
    extend_file(rounded(std::max(bytes, capacity_ + std::max(capacity_ / 8, kInMemory))));
    return;
  }
  if (bytes > kInMemory && !folder_.empty()) {
    move_to_file(rounded(2 * std::max(bytes, kInMemory)));
    return;
  }
  std::size_t capacity = rounded(std::max(bytes, 2 * capacity_));
  if (!folder_.empty()) capacity = std::max(rounded(bytes), std::min(capacity, kInMemory));
  void* const place = data_ == nullptr ? mmap(nullptr, capacity, PROT_READ | PROT_WRITE,
                                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)
                                       : mremap(data_, capacity_, capacity, MREMAP_MAYMOVE);
  if (place == MAP_FAILED) fail("", errno);
  data_ = static_cast<char*>(place);
  capacity_ = capacity;
}

void RowMemory::move_to_file(std::size_t capacity) {
  const int file = nameless_file(folder_);
  // what is mapped beyond the end of the disk would end the process when it is written
  const int error = posix_fallocate(file, 0, static_cast<off_t>(capacity));
  void* const place = error == 0
                          ? mmap(nullptr, capacity, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0)
                          : MAP_FAILED;
  if (place == MAP_FAILED) {
    const int reason = error != 0 ? error : errno;
    close(file);
    fail(folder_, reason);
  }
  if (data_ != nullptr) {
    std::memcpy(place, data_, capacity_);
    munmap(data_, capacity_);
  }
  data_ = static_cast<char*>(place);
  capacity_ = capacity;
  file_ = file;
}

void RowMemory::extend_file(std::size_t capacity) {
  const int error = posix_fallocate(file_, static_cast<off_t>(capacity_),
                                    static_cast<off_t>(capacity - capacity_));
  if (error != 0) fail(folder_, error);
  void* const place = mremap(data_, capacity_, capacity, MREMAP_MAYMOVE);
  if (place == MAP_FAILED) fail(folder_, errno);
  data_ = static_cast<char*>(place);
  capacity_ = capacity;
}

void RowMemory::let_go(std::size_t until) noexcept {
  if (!in_file() || until < let_go_ + 2 * kStep) return;
  const std::size_t whole = (until / kStep - 1) * kStep;
  // of a shared mapping the pages stay in the file
  madvise(data_ + let_go_, whole - let_go_, MADV_DONTNEED);
  let_go_ = whole;
}

void RowMemory::release() noexcept {
  if (data_ != nullptr) munmap(data_, capacity_);
  if (file_ >= 0) close(file_);
  data_ = nullptr;
  capacity_ = let_go_ = 0;
  file_ = -1;
}

void RowMemory::swap(RowMemory& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(capacity_, other.capacity_);
  std::swap(let_go_, other.let_go_);
  std::swap(file_, other.file_);
  folder_.swap(other.folder_);
}

}  // namespace c3rt::cli
