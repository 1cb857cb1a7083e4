#include "config/section.hpp"

#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

#include "tests/config/error_of.hpp"

using c3rt::config::ConfigError;
using c3rt::config::Document;
using c3rt::config::Section;
using c3rt::test::error_of;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

namespace {
const char* const kText = R"(planner:
  rate_hz: 75
  gains: [1, 2.5, 3]
  qp: direct
  verbose: true
  balls:
    - mass_kg: 0.1
    - mass_kg: 0.2
)";

Section planner(const std::vector<std::string>& overrides = {}) {
  return Document::parse(kText, "a.yaml", overrides).section("planner");
}

}  // namespace

TEST_CASE("section: values of the right type and range are read") {
  Section section = planner();
  REQUIRE(section.number("rate_hz", {1, 1000}) == 75.0);
  REQUIRE(section.integer("rate_hz", {1, 1000}) == 75);
  REQUIRE(section.numbers("gains", 3, {0, 10}) == Eigen::Vector3d(1, 2.5, 3));
  REQUIRE(section.boolean("verbose"));
  REQUIRE(section.choice<int>("qp", {{"osqp", 1}, {"direct", 2}}) == 2);
  std::vector<Section> balls = section.list("balls", 1, 4);
  REQUIRE(balls.size() == 2);
  REQUIRE(balls[1].number("mass_kg", {0, 1}) == 0.2);
}

TEST_CASE("section: an error names file, line, key, what was expected and what came") {
  CHECK_THAT(error_of([] {
               (void)planner().number("rate_hz", {100, 200});
             }),
             Equals("a.yaml:2: planner.rate_hz: expected a number in [100, 200], got \"75\""));
  CHECK_THAT(error_of([] {
               (void)planner().number("absent", {0, 1});
             }),
             Contains("planner.absent: missing"));
  CHECK_THAT(
      error_of([] {
        (void)planner().numbers("gains", 4, {0, 10});
      }),
      Equals("a.yaml:3: planner.gains: expected a list of 4 numbers in [0, 10], got a list of 3"));
  CHECK_THAT(error_of([] {
               (void)planner().numbers("gains", 3, {0, 2});
             }),
             Contains("\"2.5\" at place 2"));
  CHECK_THAT(error_of([] {
               (void)planner().integer("gains", {0, 2});
             }),
             Contains("expected an integer"));
  CHECK_THAT(error_of([] { (void)planner().boolean("qp"); }),
             Contains("expected true or false, got \"direct\""));
  CHECK_THAT(error_of([] {
               (void)planner().choice<int>("qp", {{"osqp", 1}, {"auto", 2}});
             }),
             Contains("one of osqp, auto, got \"direct\""));
  CHECK_THAT(error_of([] { (void)planner().list("balls", 3, 4); }),
             Contains("list of 3 to 4 mappings"));
}

TEST_CASE("section: what is not a finite number is refused") {
  for (const char* text : {"a: nan", "a: inf", "a: 1x", "a: ''", "a: [1]", "a: 1e999"}) {
    Section section = Document::parse(text, "b.yaml");
    CHECK_THROWS_AS(section.number("a", {-1e300, 1e300}), ConfigError);
  }
}

TEST_CASE("section: finish refuses keys that nobody read, also below") {
  Section root = Document::parse("a: 1\nb:\n  c: 1\n  d: 2\n", "c.yaml");
  (void)root.number("a", {0, 1});
  (void)root.section("b").number("c", {0, 1});
  CHECK_THAT(error_of([&] { root.finish(); }), Equals("c.yaml:4: b.d: unknown key"));
}

TEST_CASE("section: a key that is given twice is refused, wherever it stands") {
  const auto error = [](const std::string& text) {
    return error_of([&] { (void)Document::parse(text, "d.yaml"); });
  };
  CHECK_THAT(error("a: 1\na: 1\n"), Equals("d.yaml:2: a: given twice"));
  CHECK_THAT(error("a:\n  b: 1\n  c: 2\n  b: 1\n"), Equals("d.yaml:4: a.b: given twice"));
  CHECK_THAT(error("a:\n  - x: 1\n  - x: 1\n    y: 2\n    x: 3\n"),
             Equals("d.yaml:5: a.1.x: given twice"));
}

TEST_CASE("section: an error in a list names the line of the value, not of the list") {
  Section root = Document::parse("a:\n  - 1\n  - 9\nb: [\n  [1, 2],\n  [1, 9]]\n", "l.yaml");
  CHECK_THAT(error_of([&] {
               (void)root.numbers("a", 2, {0, 5});
             }),
             Equals("l.yaml:3: a: expected a list of 2 numbers in [0, 5], got \"9\" at place 2"));
  CHECK_THAT(error_of([&] {
               (void)root.rows("b", 1, 2, 2, {0, 5});
             }),
             Contains("l.yaml:6: b: ") && Contains("at place 2"));
}

TEST_CASE("section: an override replaces one key of a mapping that is there, or adds it") {
  REQUIRE(planner({"planner.rate_hz=80"}).number("rate_hz", {0, 100}) == 80.0);
  REQUIRE(
      planner({"planner.balls.1.mass_kg=0.3"}).list("balls", 2, 2)[1].number("mass_kg", {0, 1}) ==
      0.3);
  REQUIRE(planner({"planner.gains=[3, 2, 1]"}).numbers("gains", 3, {0, 10})[0] == 3.0);
  REQUIRE(planner({"planner.mass_kg=0.3"}).number("mass_kg", {0, 1}) == 0.3);
  REQUIRE(
      planner({"planner.balls.1.radius_m=0.3"}).list("balls", 2, 2)[1].number("radius_m", {0, 1}) ==
      0.3);
  // one that nobody reads is refused as if it stood in the file
  CHECK_THAT(error_of([] {
               Section root = Document::parse("c3: {rho: 1}", "a.yaml", {"c3.polis=8"});
               (void)root.section("c3").number("rho", {0, 10});
               root.finish();
             }),
             Equals("a.yaml with --set: c3.polis: unknown key"));
  CHECK_THAT(error_of([] { (void)planner({"robot.rate=80"}); }),
             Contains("--set robot.rate: no such key in a.yaml"));
  CHECK_THAT(error_of([] { (void)planner({"planner.gains.3=1"}); }), Contains("no such key"));
  CHECK_THAT(error_of([] { (void)planner({"planner.rate_hz.low=1"}); }), Contains("no such key"));
  CHECK(Document::parse(kText, "a.yaml", {"seed=1"}).number("seed", {0, 1}) == 1.0);
  CHECK_THAT(error_of([] { (void)planner({"planner.balls.7.mass_kg=1"}); }),
             Contains("no such key"));
  for (const std::string path :
       {"planner.balls..mass_kg", "planner.", "planner.rate_hz.", ".planner", "."})
    CHECK_THAT(error_of([&] { (void)planner({path + "=1"}); }), Contains("no such key"));
  CHECK_THAT(
      error_of([] {
        (void)planner({"planner.balls.1={mass_kg: 7}"})
            .list("balls", 2, 2)[1]
            .number("mass_kg", {0, 1});
      }),
      Equals("a.yaml with --set: planner.balls.1.mass_kg: expected a number in [0, 1], got \"7\""));
  CHECK_THAT(error_of([] { (void)planner({"rate"}); }), Contains("expected key=value"));
  CHECK_THAT(
      error_of([] {
        (void)planner({"planner.rate_hz=500"}).number("rate_hz", {0, 100});
      }),
      Contains("a.yaml with --set: planner.rate_hz: expected a number in [0, 100], got \"500\""));
}

TEST_CASE("section: text that is not YAML, and a file that is not there, are named") {
  CHECK_THAT(error_of([] { (void)Document::parse("a: [1", "e.yaml"); }),
             Contains("e.yaml:1: not YAML"));
  CHECK_THAT(error_of([] { (void)Document::parse("- 1", "e.yaml"); }),
             Contains("expected a mapping"));
  CHECK_THAT(
      error_of([] { (void)Document::load("absent.yaml"); }),
      Equals("absent.yaml: expected a file that can be read, got No such file or directory"));
}

TEST_CASE("section: what no scenario needs is refused before anything is built from it") {
  const auto refused = [](const std::string& text) {
    try {
      Document::parse(text, "bomb.yaml");
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  CHECK_THAT(refused("a: " + std::string(100, '[') + std::string(100, ']')),
             Catch::Contains("bomb.yaml:1: not YAML: expected at most 32 levels"));
  CHECK_THAT(refused("a: " + std::string(100000, '[')), Catch::Contains("at most 32 levels"));
  CHECK_THAT(refused("a: " + std::string(100000, '{')), Catch::Contains("at most 32 levels"));
  std::string list = "a: [0";
  for (int i = 0; i < 60000; ++i) list += ",0";
  CHECK_THAT(refused(list + "]"), Catch::Contains("at most 50000 values"));
  std::string laughs = "a0: &a0 [x, x]\n";  // each level twice as large as the one before
  for (int i = 1; i < 200; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    laughs +=
        "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before + "," + before + "]\n";
  }
  CHECK_THAT(refused(laughs), Catch::Contains("at most 100 aliases"));
  CHECK(refused("a: &x 1\nb: *x\n") == "taken");
  // few aliases that are many values, or endless
  std::string doubled = "a0: &a0 [x, x]\n";
  for (int i = 1; i < 20; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    doubled +=
        "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before + "," + before + "]\n";
  }
  CHECK_THAT(refused(doubled), Catch::Contains("at most 50000 values"));
  CHECK_THAT(refused("a: &x [*x]\n"), Catch::Contains("an alias of the value that it stands in"));
  CHECK_THAT(refused("[1, 2]: 3\n"),
             Catch::Contains("bomb.yaml:1: not YAML: expected a text as key, got a list of 2"));
}

TEST_CASE(
    "section: a file of 100 MB is refused without reading it, a folder and an empty one too") {
  const std::string path = std::string(C3RT_BINARY_DIRECTORY) + "/section_large.yaml";
  std::ofstream(path) << "name: x\n";
  std::filesystem::resize_file(path, 100'000'000);  // sparse: no bytes on the disk
  CHECK_THROWS_WITH(Document::load(path),
                    Catch::Contains("expected at most 262144 bytes, got more"));
  std::ofstream(path, std::ios::trunc).flush();
  CHECK_THROWS_WITH(Document::load(path), Catch::Contains("got an empty file"));
  std::filesystem::remove(path);
  CHECK_THROWS_WITH(Document::load(C3RT_BINARY_DIRECTORY), Catch::Contains("got a folder"));
  CHECK_THROWS_WITH(Document::load(path), Catch::Contains("No such file"));
}

TEST_CASE("section: a name is letters, digits, _ and -; a text has no control characters") {
  const auto name = [](const std::string& value) {
    return Document::parse("name: \"" + value + "\"", "x.yaml").name("name");
  };
  CHECK(name("circle_slow-2") == "circle_slow-2");
  for (const std::string bad : {"../x", "a b", "a\\n", "\\e[31m", "", "größe"})
    CHECK_THROWS_WITH(name(bad),
                      Catch::Contains("x.yaml:1: name: expected 1 to 64 letters, digits"));
  CHECK_THROWS_WITH(name(std::string(300, 'x')), Catch::Contains("1 to 64"));
  const auto text = [](const std::string& value) {
    return Document::parse("description: \"" + value + "\"", "x.yaml").text("description");
  };
  CHECK(text("größer als 3 µm") == "größer als 3 µm");
  CHECK_THROWS_WITH(text("a\\e[31mb"),
                    Catch::Contains("without control characters, got \"a\\x1b[31mb\""));
  CHECK_THROWS_WITH(text("a\\nb"), Catch::Contains("without control characters"));
  CHECK_THROWS_WITH(text(std::string(2000, 'x')), Catch::Contains("at most 1000 bytes, got 2000"));
}

TEST_CASE("section: a list of texts has as many as asked for, each without control characters") {
  Section section = Document::parse(
      "names: [tip, disc]\none: tip\nlong: [a, b, c]\nodd: [a, \"b\\e\"]\n", "a.yaml");
  CHECK(section.texts("names", 2) == std::vector<std::string>{"tip", "disc"});
  CHECK_THAT(error_of([&] { (void)section.texts("one", 2); }),
             Contains("a.yaml:2: one: expected a list of 2 texts, got \"tip\""));
  CHECK_THAT(error_of([&] { (void)section.texts("long", 2); }), Contains("a list of 2 texts"));
  CHECK_THAT(error_of([&] { (void)section.texts("odd", 2); }), Contains("without control"));
}

TEST_CASE("section: an error is one line, whatever stands in the file") {
  try {
    Document::parse("\"a\\e[2Jb\\n\": 1", "x.yaml").finish();
    FAIL("taken");
  } catch (const ConfigError& error) {
    CHECK_THAT(error.what(), Catch::Contains("a\\x1b[2Jb\\x0a: unknown key"));
  }
}

TEST_CASE("section: a file is looked for beside the file that names it, then beside the shipped") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / "c3rt_section_test_files";
  fs::create_directories(folder / "objects");
  std::ofstream(folder / "objects" / "own.xml") << "<mujoco/>";
  std::ofstream(folder / "a.yaml") << "one: objects/own.xml\n"
                                      "two: [objects/own.xml, ../objects/t.xml]\n"
                                      "absent: objects/none.xml\n"
                                      "wrong: {a: 1}\n";
  Section section = Document::load((folder / "a.yaml").string());
  const std::string own = fs::weakly_canonical(folder / "objects" / "own.xml").string();
  CHECK(section.file("one") == own);
  CHECK(section.files("one", 1, 2) == std::vector<std::string>{own});
  const std::vector<std::string> two = section.files("two", 1, 2);
  REQUIRE(two.size() == 2);
  CHECK(two[0] == own);
  CHECK(fs::is_regular_file(two[1]));
  CHECK(two[1].find("config/objects/t.xml") != std::string::npos);
  CHECK_THAT(error_of([&] { (void)section.file("absent"); }),
             Contains("a.yaml:3: absent: expected a file that is there, got objects/none.xml, "
                      "which is neither " +
                      folder.string()));
  CHECK_THAT(error_of([&] { (void)section.file("wrong"); }),
             Contains("expected the name of a file"));
  CHECK_THAT(error_of([&] { (void)section.files("two", 1, 1); }),
             Contains("expected a list of 1 to 1 files, got a list of 2"));
}
