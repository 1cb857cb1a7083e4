#include "config/extends.hpp"

#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

#include "config/directory.hpp"
#include "config/section.hpp"
#include "tests/config/error_of.hpp"

using c3rt::config::ConfigError;
using c3rt::config::Document;
using c3rt::config::load_composed;
using c3rt::config::Section;
using c3rt::config::Tree;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::Equals;
namespace fs = std::filesystem;
using c3rt::test::error_of;

namespace {

/// A folder of scenario files.
class Files {
 public:
  Files() : folder_(std::string(C3RT_BINARY_DIRECTORY) + "/extends_test") {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~Files() { fs::remove_all(folder_); }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  std::string add(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return path(name);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  fs::path folder_;
};

const char* const kBase = R"(name: base
description: what all share
planner:
  rate_hz: 75
  c3: {rho: 1, qp: direct}
  gains: [1, 2, 3]
plant:
  step_s: 0.5
)";

}  // namespace

TEST_CASE("extends: mappings merge key by key, a list is replaced as a whole") {
  const Files files;
  files.add("base.yaml", kBase);
  const std::string file = files.add("own.yaml", R"(name: own
extends: base.yaml
planner:
  c3: {rho: 2}
  gains: [7]
vision: {rate_hz: 80}
)");
  Section root = Document::load(file);
  CHECK(root.name("name") == "own");
  Section planner = root.section("planner");
  CHECK(planner.number("rate_hz", {0, 100}) == 75.0);
  CHECK(planner.numbers("gains", 1, {0, 10})[0] == 7.0);
  Section c3 = planner.section("c3");
  CHECK(c3.number("rho", {0, 10}) == 2.0);
  CHECK(c3.text("qp") == "direct");
  CHECK(root.section("vision").number("rate_hz", {0, 100}) == 80.0);
  CHECK(root.section("plant").number("step_s", {0, 1}) == 0.5);
  root.finish();
}

TEST_CASE("extends: name and description are the file's own") {
  const Files files;
  files.add("base.yaml", kBase);
  const std::string file = files.add("own.yaml", "extends: base.yaml\nplanner: {rate_hz: 1}\n");
  CHECK_THAT(error_of([&] { (void)Document::load(file).name("name"); }),
             EndsWith("own.yaml:1: name: missing"));
  CHECK_FALSE(Document::load(file).has("description"));
}

TEST_CASE("extends: an error names the file and the line where the value was written") {
  const Files files;
  files.add("base.yaml", kBase);
  files.add("middle.yaml", "extends: base.yaml\n\nplanner:\n  c3: {qp: osqp}\n");
  const std::string file =
      files.add("own.yaml", "extends: middle.yaml\nplanner:\n  c3:\n    rho: 9\n");
  Section planner = Document::load(file).section("planner");
  Section c3 = planner.section("c3");
  CHECK_THAT(error_of([&] {
               (void)planner.number("rate_hz", {0, 10});
             }),
             Equals(files.path("base.yaml") +
                    ":4: planner.rate_hz: expected a number in [0, 10], got \"75\""));
  CHECK_THAT(error_of([&] {
               (void)planner.numbers("gains", 3, {0, 2});
             }),
             Contains("base.yaml:6: planner.gains"));
  CHECK_THAT(error_of([&] {
               (void)c3.choice<int>("qp", {{"direct", 0}});
             }),
             Equals(files.path("middle.yaml") +
                    ":4: planner.c3.qp: expected one of direct, got \"osqp\""));
  CHECK_THAT(error_of([&] {
               (void)c3.number("rho", {0, 5});
             }),
             Equals(files.path("own.yaml") +
                    ":4: planner.c3.rho: expected a number in [0, 5], got \"9\""));
  // a key that nobody reads
  Section again = Document::load(file);
  (void)again.section("planner").section("c3").number("rho", {0, 10});
  CHECK_THAT(error_of([&] { again.finish(); }), EndsWith("base.yaml:7: plant: unknown key"));
  // the mapping that lacks a key is where the file itself speaks of it, else the base's
  CHECK_THAT(error_of([&] {
               (void)c3.number("eps", {0, 1});
             }),
             EndsWith("own.yaml:4: planner.c3.eps: missing"));
  CHECK_THAT(error_of([&] {
               (void)Document::load(file).section("plant").number("mass", {0, 1});
             }),
             EndsWith("base.yaml:8: plant.mass: missing"));
}

TEST_CASE("extends: --set replaces one key of the whole, whichever file it is from") {
  const Files files;
  files.add("base.yaml", kBase);
  const std::string file = files.add("own.yaml", "extends: base.yaml\nplanner: {c3: {rho: 2}}\n");
  Section planner =
      Document::load(file, {"planner.rate_hz=80", "planner.c3.rho=99", "planner.gains.1=5"})
          .section("planner");
  CHECK(planner.number("rate_hz", {0, 100}) == 80.0);
  CHECK(planner.numbers("gains", 3, {0, 10}) == Eigen::Vector3d(1, 5, 3));
  CHECK_THAT(
      error_of([&] {
        (void)planner.section("c3").number("rho", {0, 10});
      }),
      EndsWith("own.yaml with --set: planner.c3.rho: expected a number in [0, 10], got \"99\""));
  CHECK_THAT(error_of([&] { (void)Document::load(file, {"plan.rate=80"}); }),
             Contains("--set plan.rate: no such key in " + file));
  CHECK_THAT(error_of([&] { (void)Document::load(file, {"extends=base"}); }),
             Contains("no such key"));
}

TEST_CASE("extends: a key with nothing takes the base's key out, and has to find one") {
  const Files files;
  files.add("base.yaml", kBase);
  const std::string file =
      files.add("own.yaml", "extends: base.yaml\nplanner:\n  c3: {rho: ~}\n  gains:\n");
  Section planner = Document::load(file).section("planner");
  CHECK_FALSE(planner.has("gains"));
  CHECK_FALSE(planner.section("c3").has("rho"));
  CHECK(planner.section("c3").has("qp"));
  const std::string wrong = files.add("wrong.yaml", "extends: base.yaml\nplanner:\n  rate: ~\n");
  CHECK_THAT(
      error_of([&] { (void)Document::load(wrong); }),
      EndsWith("wrong.yaml:3: planner.rate: expected a value, or a key of what this extends to "
               "leave out, got nothing"));
}

TEST_CASE("extends: a name is that of a shipped scenario, a path is seen from the file") {
  const Files files;
  // named as what it extends: no circle
  const std::string named =
      files.add("circle_slow.yaml", "name: mine\nextends: circle_slow\nplanner: {rate_hz: 42}\n");
  const Tree tree = load_composed(named);
  CHECK(tree.find("planner")->find("rate_hz")->scalar == "42");
  CHECK(*tree.find("planner")->find("c3")->place.file ==
        (c3rt::config::directory() / "scenarios" / "circle_slow.yaml").string());
  const std::string beside =
      files.add("deep/er/own.yaml", "extends: ../../circle_slow.yaml\nplanner: {rate_hz: 43}\n");
  CHECK(load_composed(beside).find("planner")->find("rate_hz")->scalar == "43");
  CHECK(load_composed(beside).find("impedance") != nullptr);
  const std::string absolute = files.add("absolute.yaml", "extends: " + named + "\n");
  CHECK(load_composed(absolute).find("planner")->find("rate_hz")->scalar == "42");
}

TEST_CASE("extends: a base that is not there is refused by file and line") {
  const Files files;
  const auto error = [&](const std::string& extends) {
    const std::string file = files.add("own.yaml", "name: own\nextends: " + extends + "\n");
    return error_of([&] { (void)Document::load(file); });
  };
  CHECK_THAT(error("circle_slwo"),
             Contains("own.yaml:2: extends: expected the name of a scenario in ") &&
                 Contains("scenarios, or a path to a .yaml file, got \"circle_slwo\""));
  CHECK_THAT(error("absent.yaml"),
             Contains("own.yaml:2: extends: expected a file, got \"absent.yaml\""));
  CHECK_THAT(error("./"), Contains("own.yaml:2: extends: expected a file"));
  CHECK_THAT(error("/dev/zero"), Contains("own.yaml:2: extends: expected a file"));
  for (const std::string bad : {"[circle_slow, circle_fast]", "{name: x}", "~", "''"})
    CHECK_THAT(error(bad),
               Contains("own.yaml:2: extends: expected the name of a scenario or a path"));
  CHECK_THAT(error("'a b'"), Contains("got \"a b\""));
}

TEST_CASE("extends: a circle and too long a chain are refused") {
  const Files files;
  files.add("a.yaml", "extends: b.yaml\n");
  files.add("b.yaml", "x: 1\nextends: ./sub/../c.yaml\n");
  files.add("c.yaml", "extends: a.yaml\n");
  fs::create_directories(files.path("sub"));
  CHECK_THAT(
      error_of([&] { (void)Document::load(files.path("a.yaml")); }),
      Contains("c.yaml:1: extends: expected no circle, got a.yaml -> b.yaml -> c.yaml -> a.yaml"));
  files.add("self.yaml", "x: 1\nextends: self.yaml\n");
  CHECK_THAT(error_of([&] { (void)Document::load(files.path("self.yaml")); }),
             Contains("self.yaml:2: extends: expected no circle, got self.yaml -> self.yaml"));
  files.add("level0.yaml", "x: 0\n");
  for (int i = 1; i <= 8; ++i)
    files.add("level" + std::to_string(i) + ".yaml",
              "extends: level" + std::to_string(i - 1) + ".yaml\n");
  CHECK(load_composed(files.path("level7.yaml")).find("x")->scalar == "0");
  CHECK_THAT(error_of([&] { (void)Document::load(files.path("level8.yaml")); }),
             Contains("level1.yaml:1: extends: expected at most 8 files"));
}

TEST_CASE("extends: what is wrong in a base is told of the base") {
  const Files files;
  files.add("base.yaml", "x: 1\ny: [1\n");
  const std::string file = files.add("own.yaml", "extends: base.yaml\n");
  CHECK_THAT(error_of([&] { (void)Document::load(file); }),
             Contains("base.yaml:") && Contains("not YAML"));
  files.add("base.yaml", "x: 1\nx: 2\n");
  CHECK_THAT(error_of([&] { (void)Document::load(file); }),
             EndsWith("base.yaml:2: x: given twice"));
  files.add("base.yaml", "- 1\n");
  CHECK_THAT(error_of([&] { (void)Document::load(file); }),
             Contains("base.yaml: expected a mapping"));
  files.add("base.yaml", "");
  CHECK_THAT(error_of([&] { (void)Document::load(file); }),
             Contains("base.yaml") && Contains("an empty file"));
}
