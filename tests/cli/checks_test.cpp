#include "cli/checks.hpp"

#include <catch2/catch.hpp>

#include "cli/examples.hpp"

using namespace c3rt::cli;
using Catch::Contains;

namespace {

std::string said(const CLI::Validator& check, std::string input) { return check(input); }

}  // namespace

TEST_CASE("checks: a number is finite, whole where it must be, and in its range") {
  for (const char* good : {"0", "0.5", "1", "1e-3", "+0.25"})
    CHECK(said(number(0, 1), good).empty());
  for (const char* bad : {"nan", "inf", "-inf", "1e999", "1.0001", "-1e-9", "", "1x", "0x1", " 1"})
    CHECK_THAT(said(number(0, 1), bad), Contains("expected a number from 0 to 1, got"));
  for (const char* good : {"0", "230", "+7"}) CHECK(said(whole(0, 230), good).empty());
  for (const char* bad : {"231", "-1", "1.0", "1e1", "any", "99999999999999999999"})
    CHECK_THAT(said(whole(0, 230), bad), Contains("expected a whole number from 0 to 230, got"));
  CHECK(said(whole_or(0, 230, "any"), "any").empty());
  CHECK_THAT(said(whole_or(0, 230, "any"), "all"), Contains("0 to 230, or any, got \"all\""));
}

TEST_CASE("checks: a length of time has a unit or is in seconds, and becomes seconds") {
  const auto seconds = [](std::string input) {
    const std::string wrong = duration(1, 172800)(input);
    return wrong.empty() ? std::stod(input) : -1.0;
  };
  CHECK(seconds("90") == 90.0);
  CHECK(seconds("10s") == 10.0);
  CHECK(seconds("90m") == 5400.0);
  CHECK(seconds("1.5min") == 90.0);
  CHECK(seconds("24h") == 86400.0);
  CHECK(seconds("2d") == 172800.0);
  for (const char* bad :
       {"", "h", "0.5", "49h", "10 s", "10x", "10ms", "nan", "infm", "-5m", "1h30m"})
    CHECK(seconds(bad) == -1.0);
  CHECK_THAT(said(duration(1, 172800), "10x"),
             Contains("expected a time from 1 s to 48 h, as 90s, 15m, 24h, got \"10x\""));
}

TEST_CASE("checks: what was typed is shown without control characters and cut") {
  CHECK_THAT(said(whole(0, 9), "\x1b[2J"), Contains("got \"\\x1b[2J\""));
  CHECK(said(whole(0, 9), std::string(100000, 'x')).size() < 300);
}

TEST_CASE("checks: the nearest word is suggested, one that is far from all is not") {
  const std::vector<std::string> words{"status", "stop", "recover", "run", "reproduce", "up"};
  CHECK(nearest("staus", words) == "status");
  CHECK(nearest("rnu", words) == "run");
  CHECK(nearest("repro", words) == "reproduce");
  CHECK(nearest("frobnicate", words).empty());
  CHECK(nearest("", words).empty());
  CHECK(nearest(std::string(1000000, 'x'), words).empty());
}

TEST_CASE("checks: a command without examples cannot be made") {
  CHECK_THROWS_AS(examples_of("no such command"), std::out_of_range);
}
