#include "cli/report/text_table.hpp"

#include <limits>

#include <catch2/catch.hpp>

using namespace c3rt::cli;

TEST_CASE("a table of text: first column left, others right, headings take no room of a column") {
  CHECK(text_table({{"what", "n"}, {"a heading that is long"}, {"µ", "12"}, {"xyz"}}) ==
        "what   n\n"
        "a heading that is long\n"
        "µ     12\n"
        "xyz\n");
}

TEST_CASE("a table of Markdown has its rule after the head and as many cells in each row") {
  CHECK(markdown_table({{"what", "n"}, {"part"}, {"a", "1"}}) ==
        "| what | n |\n| --- | --- |\n| **part** |  |\n| a | 1 |\n");
}

TEST_CASE("a number is shown with the digits wanted, and what is not there as a dash") {
  CHECK(shown(0.123456) == "0.1235");
  CHECK(shown(2.0 / 3.0, 2) == "0.67");
  CHECK(shown(std::numeric_limits<double>::quiet_NaN()) == "-");
}
