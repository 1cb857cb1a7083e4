#include "cli/campaign/seeds.hpp"

#include <catch2/catch.hpp>

#include "cli/paths.hpp"

using c3rt::cli::UsageError;
using c3rt::cli::campaign::parse_seeds;
using Seeds = std::vector<std::uint64_t>;

TEST_CASE("seeds are numbers and ranges, in the order written, both ends included") {
  CHECK(parse_seeds("7") == Seeds{7});
  CHECK(parse_seeds("3..6") == Seeds{3, 4, 5, 6});
  CHECK(parse_seeds("5..5") == Seeds{5});
  CHECK(parse_seeds("1,5,9..12") == Seeds{1, 5, 9, 10, 11, 12});
  CHECK(parse_seeds("9,1..2,0") == Seeds{9, 1, 2, 0});
  CHECK(parse_seeds("18446744073709551615") == Seeds{18446744073709551615U});
  CHECK(parse_seeds("18446744073709551614..18446744073709551615").size() == 2);
}

TEST_CASE("what is no list of seeds is refused with the word and with what was expected") {
  for (const char* text : {"", "a", "1,", ",1", "1..", "..4", "1...4", "-1", "1 2", "1.5", "0x10",
                           "18446744073709551616", "1-5"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_seeds(text), UsageError);
    CHECK_THROWS_WITH(parse_seeds(text), Catch::Contains(std::string("--seeds \"") + text + "\"") &&
                                             Catch::Contains("1,5,9..12"));
  }
  CHECK_THROWS_WITH(parse_seeds("5..2"), Catch::Contains("\"5..2\" runs backwards"));
  CHECK_THROWS_WITH(parse_seeds("1..4,3"), Catch::Contains("seed 3 comes twice"));
  CHECK_THROWS_WITH(parse_seeds("1..18446744073709551615"), Catch::Contains("more than 100000"));
}
