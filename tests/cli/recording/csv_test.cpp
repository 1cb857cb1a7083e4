#include "cli/recording/csv.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/cli/folder.hpp"
#include "tests/support/small_disk.hpp"

using namespace c3rt;
using namespace c3rt::cli;

TEST_CASE("the samples of a topic are a table with as many names as numbers") {
  const Folder folder;
  {
    TopicCsv<wire::ObjectEstimate> log(folder.path());
    wire::ObjectEstimate sample{};
    sample.header = {7, 12, 34'000'000};
    sample.p_WB_m[1] = 0.125;
    log.add(sample);
    // a table that is not whole has another name
    REQUIRE_FALSE(std::filesystem::exists(folder.path() / "object_estimate.csv"));
    log.finish();
  }
  std::ifstream file(folder.path() / "object_estimate.csv");
  std::string names, numbers;
  REQUIRE(std::getline(file, names));
  REQUIRE(std::getline(file, numbers));
  const auto cells = [](const std::string& line) {
    std::vector<std::string> all;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) all.push_back(cell);
    return all;
  };
  const auto head = cells(names), row = cells(numbers);
  REQUIRE(head.size() == row.size());
  const auto value = [&](const std::string& name) {
    const auto at = std::find(head.begin(), head.end(), name);
    REQUIRE(at != head.end());
    return row[static_cast<std::size_t>(at - head.begin())];
  };
  REQUIRE(value("time_ns") == "34000000");
  REQUIRE(value("seq") == "12");
  REQUIRE(value("p_WB_m_1") == "0.125");
}

TEST_CASE("a table that the disk has no room for says so, and leaves no table that looks whole") {
  const c3rt::test::SmallDisk disk;
  if (!disk.mounted()) {
    WARN("no file system can be mounted here");
    return;
  }
  TopicCsv<wire::RobotState> log(disk.path());
  const auto fill = [&] {
    wire::RobotState sample{};
    for (int i = 0; i < 100000; ++i) log.add(sample);
    log.finish();
  };
  REQUIRE_THROWS_WITH(fill(), Catch::Contains("robot_state.csv: No space left on device"));
  REQUIRE_FALSE(std::filesystem::exists(disk.path() / "robot_state.csv"));
}
