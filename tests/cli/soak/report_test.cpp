#include "cli/soak/report.hpp"

#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cli/paths.hpp"
#include "tests/cli/folder.hpp"
#include "tests/support/small_disk.hpp"

using namespace c3rt::cli;
using namespace c3rt::cli::soak;

TEST_CASE("soak: a curve keeps its ends and its shape, and never becomes too long") {
  Thinned curve;
  constexpr int kCount = 1'000'000;
  for (int i = 0; i < kCount; ++i) curve.add(i, 2.0 * i);
  const auto& points = curve.points();
  CHECK(points.size() < Thinned::kMost);
  CHECK(points.size() > Thinned::kMost / 4);
  CHECK(points.front().first == 0.0);
  CHECK(points.back().first > kCount - 2 * kCount / static_cast<double>(points.size()));
  for (std::size_t i = 1; i < points.size(); ++i) {
    REQUIRE(points[i].first > points[i - 1].first);
    REQUIRE(points[i].second == 2.0 * points[i].first);
  }
}

TEST_CASE("soak: the report has what was found, where, and how to see it again") {
  invariants::Violations violations;
  violations.begin_pass(4, 20);
  violations.add("torque", "robot/state", 12.5, 90.0, 87.0, "N m");
  invariants::Processes processes({}, violations);
  invariants::ProcessSample sample;
  sample.name = "planner";
  sample.pid = 41;
  sample.memory = 30 << 20;
  sample.threads = 5;
  for (int t = 0; t <= 400; t += 100) processes.hear(t, sample);
  sample.memory += 512 << 10;
  processes.hear(500, sample);
  Summary summary;
  summary.scenario = "circle_slow";
  summary.clock = "lockstep";
  summary.result = "violated";
  summary.passes = 4;
  summary.again = {"c3rt soak circle_slow --seed 20 --in-process --passes 1"};
  const auto json = to_json(summary, violations, processes.courses());
  CHECK(json.at("violations").at("count") == 1);
  CHECK(json.at("violations").at("by_name").at("torque") == 1);
  const auto& first = json.at("violations").at("first").at(0);
  CHECK(first.at("seed") == 20);
  CHECK(first.at("time_s") == 12.5);
  CHECK(json.at("reproduce").at(0) == summary.again.front());
  const auto& process = json.at("processes").at(0);
  CHECK(process.at("name") == "planner");
  CHECK(process.at("memory_grown_bytes") == 512.0 * 1024.0);
  CHECK(process.at("at_5_min").at("threads") == 5);

  const std::string text = to_text(summary, violations, processes.courses());
  CHECK_THAT(text, Catch::Contains("1 torque") && Catch::Contains("pass 4, seed 20") &&
                       Catch::Contains("+512 KiB since 5 minutes") &&
                       Catch::Contains(summary.again.front()));
}

TEST_CASE("soak: passes and looks at processes are in files, line by line, while it goes on") {
  const Folder folder;
  Files files(folder.path());
  Pass pass;
  pass.number = 2;
  pass.seed = 18;
  pass.duration = 57.6;
  pass.loops = 3;
  pass.whole = pass.met = true;
  pass.log_hash = "abc";
  files.add(pass);
  invariants::ProcessSample sample;
  sample.name = "plant";
  sample.pid = 7;
  sample.memory = 4096;
  files.add(60.0, sample);
  CHECK_THAT(read_text(folder.path() / "passes.csv"),
             Catch::EndsWith("\n2,18,57.600,3,1,1,0,abc\n"));
  CHECK_THAT(read_text(folder.path() / "processes.csv"),
             Catch::EndsWith("\n60.000,plant,7,4096,0,0,0\n"));
  CHECK(files.memory().at("plant").points().size() == 1);
  CHECK_THROWS_AS(Files(folder.path() / "nowhere"), std::runtime_error);
}

TEST_CASE("soak: lines that a full disk costs are counted, and others come behind them") {
  const c3rt::test::SmallDisk disk;
  if (!disk.mounted()) {
    WARN("no file system can be mounted here");
    return;
  }
  Files files(disk.path());
  const auto filler = disk.path() / "filler";
  std::ofstream(filler) << std::string(std::size_t{1} << 20, 'x');
  invariants::ProcessSample sample;
  sample.name = "plant";
  for (int i = 0; i < 200; ++i) files.add(i, sample);
  CHECK(files.lost() > 0);
  std::filesystem::remove(filler);
  const std::uint64_t lost = files.lost();
  files.add(1000.0, sample);
  files.add(1001.0, sample);
  CHECK(files.lost() == lost);
  CHECK_THAT(read_text(disk.path() / "processes.csv"),
             Catch::EndsWith("\n1001.000,plant,0,0,0,0,0\n"));
}
