#include "cli/report/long_rows.hpp"

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "tests/cli/folder.hpp"
#include "tests/support/small_disk.hpp"

using namespace c3rt::cli;

namespace {

struct Row {
  std::int64_t time;
  double value[6];
};

Row row(std::int64_t i) { return {i, {0.5 * static_cast<double>(i), 1, 2, 3, 4, 5}}; }

/// Of this process, the pages of every mapping [bytes].
std::size_t resident() {
  std::size_t size = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> size >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

TEST_CASE("long rows: what was appended is there in order, in memory and in a file alike") {
  const Folder folder;
  constexpr std::int64_t kCount = 100'000;  // 5.6 MB
  for (const std::filesystem::path& where : {std::filesystem::path(), folder.path()}) {
    LongRows<Row> rows(where);
    for (std::int64_t i = 0; i < kCount; ++i) rows.push_back(row(i));
    CHECK(rows.in_file() == !where.empty());
    REQUIRE(rows.size() == kCount);
    bool same = true;
    std::int64_t i = 0;
    for (const Row& each : rows) {
      same = same && each.time == i && each.value[0] == 0.5 * static_cast<double>(i);
      ++i;
    }
    CHECK(same);
    CHECK(rows.front().time == 0);
    CHECK(rows.back().time == kCount - 1);
    CHECK(rows[12'345].time == 12'345);
  }
}

TEST_CASE(
    "long rows: however many there are, appending takes no more memory, and nothing is left") {
  const Folder folder;
  LongRows<Row> rows(folder.path());
  constexpr std::int64_t kBefore = 200'000, kAfter = 2'000'000;  // 11 MB, 112 MB
  for (std::int64_t i = 0; i < kBefore; ++i) rows.push_back(row(i));
  const std::size_t before = resident();
  for (std::int64_t i = kBefore; i < kAfter; ++i) rows.push_back(row(i));
  CHECK(resident() < before + (2u << 20));
  CHECK(rows[kAfter / 2].time == kAfter / 2);
  // the file has no name, so no end of the process leaves it behind
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("long rows: a disk without room is told, and what was there is still there") {
  const c3rt::test::SmallDisk disk("4m");
  if (!disk.mounted()) {
    WARN("no right to mount a small disk");
    return;
  }
  LongRows<Row> rows(disk.path());
  std::string said;
  try {
    for (std::int64_t i = 0; i < 1'000'000; ++i) rows.push_back(row(i));
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  CHECK(said ==
        "no room for the time series in " + disk.path().string() + ": No space left on device");
  CHECK(rows.size() > 10'000);
  CHECK(rows.back().time == static_cast<std::int64_t>(rows.size()) - 1);
}

TEST_CASE("long rows: copies are apart, what is moved or cleared is empty and goes on") {
  const Folder folder;
  LongRows<Row> rows(folder.path());
  for (std::int64_t i = 0; i < 50'000; ++i) rows.push_back(row(i));
  LongRows<Row> copy = rows;
  copy[7].time = -1;
  CHECK(rows[7].time == 7);
  rows.push_back(rows.front());  // one of its own, whose place changes
  CHECK(rows.back().time == 0);
  const LongRows<Row> moved = std::move(rows);
  CHECK(moved.size() == 50'001);
  copy.clear();
  CHECK(copy.empty());
  CHECK_FALSE(copy.in_file());
  copy.push_back(row(3));
  CHECK(copy.back().time == 3);
}
