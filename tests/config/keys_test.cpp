#include "config/keys.hpp"

#include <catch2/catch.hpp>

#include "config/section.hpp"

using c3rt::config::Document;
using c3rt::config::Key;
using c3rt::config::KeyListener;
using c3rt::config::Section;

namespace {

Section open(const std::string& text) { return Document::parse(text, "keys.yaml"); }

}  // namespace

TEST_CASE("KeyListener hears what each key may be, of all items of a list as one") {
  const KeyListener listener;
  Section root = open("planner: {rate_hz: 80, bodies: [{mass_kg: 1}, {mass_kg: 2}]}");
  Section planner = root.section("planner");
  planner.number("rate_hz", {1, 1000});
  for (Section& body : planner.list("bodies", 1, 8)) body.number("mass_kg", {0, 5});
  CHECK(listener.keys().at("planner.rate_hz").expected ==
        std::vector<std::string>{"a number in [1, 1000]"});
  CHECK(listener.keys().at("planner.bodies.*.mass_kg").expected ==
        std::vector<std::string>{"a number in [0, 5]"});
  CHECK_FALSE(listener.keys().at("planner.rate_hz").optional);
}

TEST_CASE("KeyListener hears of keys that are not there, and what stands in their place") {
  const KeyListener listener;
  Section root = open("{}");
  CHECK(root.number("limit_n", {0, 9}, 2.5) == 2.5);
  CHECK_FALSE(root.has("mass_scale"));
  const Key& limit = listener.keys().at("limit_n");
  CHECK(limit.expected == std::vector<std::string>{"a number in [0, 9]"});
  CHECK(limit.optional);
  CHECK(limit.missing == "2.5");
  CHECK(listener.keys().at("mass_scale").optional);
}

TEST_CASE("KeyListener keeps each of the answers to a key that readers ask for differently") {
  const KeyListener listener;
  for (const int size : {2, 3, 3}) open("{at: 1}").one_or_each("at", size, {0, 1});
  CHECK(listener.keys().at("at").expected.size() == 2);
}

TEST_CASE("KeyListener hears nothing once another one listens, and goes on after it") {
  const KeyListener outer;
  {
    const KeyListener inner;
    open("{a: true}").boolean("a");
    CHECK(inner.keys().count("a") == 1);
  }
  open("{b: true}").boolean("b");
  CHECK(outer.keys().count("a") == 0);
  CHECK(outer.keys().count("b") == 1);
}
