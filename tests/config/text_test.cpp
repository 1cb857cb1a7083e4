#include "config/text.hpp"

#include <catch2/catch.hpp>

using namespace c3rt::config;

TEST_CASE("text: control characters and what is no UTF-8 are shown as numbers") {
  CHECK(printable("a ball, 0.1 m: größer ≤ 3 µm") == "a ball, 0.1 m: größer ≤ 3 µm");
  CHECK(printable("a\x1b[2Jb\nc\td\x7f") == "a\\x1b[2Jb\\x0ac\\x09d\\x7f");
  CHECK(printable("\xc2\x9b"
                  "31m") == "\\xc2\\x9b31m");  // the one-byte CSI of ISO 6429 in UTF-8
  CHECK(printable("\xff\xc3") == "\\xff\\xc3");
  CHECK(printable("\xe2\x82") == "\\xe2\\x82");  // cut in the middle of a letter
  CHECK(printable(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(printable(std::string(1000, 'x')).size() < 210);
}

TEST_CASE("text: a name is letters, digits, _ and -, and not longer than 64") {
  for (const char* good : {"circle_slow", "a", "A-1", "three_balls_plus"}) CHECK(is_name(good));
  for (const char* bad : {"", "a b", "../x", "a/b", "a.b", "größe", "a\nb", "\x1b[31m"})
    CHECK_FALSE(is_name(bad));
  CHECK(is_name(std::string(64, 'x')));
  CHECK_FALSE(is_name(std::string(65, 'x')));
}
