#include "cli/paths.hpp"

#include <fstream>

#include <catch2/catch.hpp>

#include "tests/cli/folder.hpp"
#include "tests/support/small_disk.hpp"

using namespace c3rt::cli;
namespace fs = std::filesystem;

TEST_CASE("paths: a folder with room is left as it was") {
  const Folder folder;
  require_room(folder.path());
  CHECK(fs::is_empty(folder.path()));
  CHECK_FALSE(is_full(folder.path()));
  CHECK_THROWS_WITH(require_room(folder.path() / "none"), Catch::Contains("No such file"));
}

TEST_CASE("paths: on a full disk a file is written whole or not at all, and it is said why") {
  const c3rt::test::SmallDisk disk;
  if (!disk.mounted()) {
    WARN("no file system can be mounted here");
    return;
  }
  write_text(disk.path() / "report.json", "old\n");
  require_room(disk.path());
  CHECK_THROWS_WITH(write_text(disk.path() / "report.json", std::string(1 << 20, 'x')),
                    Catch::Contains("report.json: No space left on device"));
  CHECK(read_text(disk.path() / "report.json") == "old\n");
  CHECK(std::distance(fs::directory_iterator(disk.path()), {}) == 1);
  std::ofstream(disk.path() / "filler") << std::string(600000, 'x');
  CHECK(is_full(disk.path()));
  CHECK(is_small_disk(disk.path()));
  CHECK_THROWS_WITH(require_room(disk.path()),
                    Catch::Contains("no room for logs and results in ") &&
                        Catch::Contains("No space left on device"));
}
