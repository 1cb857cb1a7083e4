#include "config/show.hpp"

#include <filesystem>

#include <catch2/catch.hpp>

#include "config/directory.hpp"
#include "config/extends.hpp"

using namespace c3rt::config;
using Catch::Matchers::Contains;

namespace {

/// Value by value; places do not count.
bool same(const Tree& a, const Tree& b) {
  if (a.kind != b.kind || a.scalar != b.scalar || a.list.size() != b.list.size() ||
      a.map.size() != b.map.size())
    return false;
  for (std::size_t i = 0; i < a.list.size(); ++i)
    if (!same(a.list[i], b.list[i])) return false;
  for (std::size_t i = 0; i < a.map.size(); ++i)
    if (a.map[i].key != b.map[i].key || !same(a.map[i].value, b.map[i].value)) return false;
  return true;
}

}  // namespace

TEST_CASE(
    "show: every shipped scenario is read again as the same tree, with comments and without") {
  for (const auto& entry : std::filesystem::directory_iterator(directory() / "scenarios")) {
    CAPTURE(entry.path());
    const Tree tree = load_composed(entry.path().string());
    for (const Comments comments : {Comments::kNone, Comments::kPlaces})
      CHECK(same(tree, parse_yaml(show(tree, comments), "shown.yaml")));
  }
}

TEST_CASE("show: whatever text a file has comes back as the same text") {
  const std::string text = R"(plain: a-b_c.5
number: -1.0e-3
limit: -.inf
empty: ""
nul: "null"
tilde: "~"
quotes: 'a "b" \ c'
colon: "a: b # c"
dashes: "---"
control: "a\tb\nc\x1b"
utf8: größer als 3 µm
"key: with colon": 1
nothing: ~
list: []
map: {}
nested: {a: [1, {b: [x, y]}, [2]], c: {d: {e: 1}}}
)";
  const Tree tree = parse_yaml(text, "a.yaml");
  CHECK(same(tree, parse_yaml(show(tree, Comments::kNone), "b.yaml")));
  CHECK(same(tree, parse_yaml(show(tree, Comments::kPlaces), "b.yaml")));
}

TEST_CASE("show: each line says which file and line it is from") {
  const std::string file = std::string(C3RT_BINARY_DIRECTORY) + "/shown.yaml";
  const Tree tree = compose("name: shown\nextends: circle_slow\nplanner:\n  rate_hz: 42\n", file,
                            {"planner.horizon=3"});
  const std::string text = show(tree, Comments::kPlaces);
  const auto line_of = [&](const std::string& key) {
    const std::size_t at = text.find("\n" + key);
    return at == std::string::npos ? "no line"
                                   : text.substr(at + 1, text.find('\n', at + 1) - at - 1);
  };
  CHECK_THAT(text, Catch::StartsWith("name: shown "));
  CHECK_THAT(line_of("  rate_hz: 42"), Catch::EndsWith(" # shown.yaml:4"));
  CHECK_THAT(line_of("  horizon: 3"), Catch::EndsWith(" # --set"));
  CHECK_THAT(line_of("  speed_limit_m_per_s: "), Contains(" # circle_slow.yaml:"));
  CHECK_THAT(line_of("    - {shape: sphere, position_m: [0.55, 0.1]"),
             Contains(" # circle_slow.yaml:"));
}

TEST_CASE("show: files of one name are told apart by their folders") {
  const std::string file = std::string(C3RT_BINARY_DIRECTORY) + "/circle_slow.yaml";
  const std::string text =
      show(compose("name: mine\nextends: circle_slow\n", file), Comments::kPlaces);
  CHECK_THAT(text, Contains("# " + file + ":1"));
  CHECK_THAT(text, Contains("# " + (directory() / "scenarios/circle_slow.yaml").string() + ":"));
}
