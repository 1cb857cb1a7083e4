// Which numbers c3rt tune looks for, and how they are seen.
#include "cli/tune/search.hpp"

#include <catch2/catch.hpp>

#include "cli/paths.hpp"

using namespace c3rt::cli::tune;
using c3rt::cli::UsageError;
using c3rt::config::parse_yaml;
using Catch::Contains;

TEST_CASE("a number is a key, or several, with a range") {
  const Parameter parameter = parse_parameter(Scale::kLogarithmic, "a.b,a.c=1e-2..1e+2");
  CHECK(parameter.keys == std::vector<std::string>{"a.b", "a.c"});
  CHECK(parameter.low == 0.01);
  CHECK(parameter.high == 100.0);
  CHECK(parse_parameter(Scale::kLinear, "a=-3..-1").low == -3.0);
  for (const char* wrong : {"", "a", "a=1", "a=1..", "=1..2", "a,=1..2", "a=1..x", "a=nan..1"})
    CHECK_THROWS_WITH(parse_parameter(Scale::kLinear, wrong), Contains("expected KEY=LOW..HIGH"));
  CHECK_THROWS_WITH(parse_parameter(Scale::kLinear, "a=2..1"), Contains("lower end"));
  CHECK_THROWS_WITH(parse_parameter(Scale::kLogarithmic, "a=0..1"), Contains("above 0"));
  CHECK_THROWS_WITH(parse_parameter(Scale::kWhole, "a=1..2.5"), Contains("whole numbers"));
}

TEST_CASE("a range is [0, 1]: by halves, by factors, by whole numbers") {
  const Parameter linear = parse_parameter(Scale::kLinear, "a=2..6"),
                  log = parse_parameter(Scale::kLogarithmic, "a=0.1..1000"),
                  whole = parse_parameter(Scale::kWhole, "a=1..5");
  CHECK(from_unit(linear, 0.25) == Approx(3.0));
  CHECK(from_unit(log, 0.25) == Approx(1.0));
  CHECK(from_unit(whole, 0.3) == 2.0);  // of 2.2
  for (const Parameter& parameter : {linear, log}) {
    for (const double unit : {0.0, 0.3, 1.0})
      CHECK(to_unit(parameter, from_unit(parameter, unit)) == Approx(unit).margin(1e-12));
  }
  CHECK(from_unit(log, 1.0 + 1e-9) <= 1000.0);
  CHECK(from_unit(log, -1.0) >= 0.1);
}

TEST_CASE("the search begins where the scenario is, and what does not fit is said") {
  const auto scenario = parse_yaml("a: {b: 10, c: 10, d: 3, list: [7], word: fast}", "s.yaml");
  const auto begin = [&](Scale scale, const char* text) {
    return start({parse_parameter(scale, text)}, scenario, "s.yaml");
  };
  CHECK(begin(Scale::kLogarithmic, "a.b,a.c=1..1000")[0] == Approx(1.0 / 3.0));
  CHECK(begin(Scale::kLinear, "a.list.0=6..8")[0] == Approx(0.5));
  for (const auto& [text, says] : {std::pair{"a.x=1..2", "a.x: no such key in s.yaml"},
                                   {"a.word=1..2", "expected a number in s.yaml, got \"fast\""},
                                   {"a=1..2", "expected a number"},
                                   {"a.b=1..2", "in 1 to 2, got 10"},
                                   {"a.b,a.d=1..20", "the value of a.b, 10, got 3"},
                                   {"a.b,a.b=1..20", "named twice"}})
    CHECK_THROWS_WITH(begin(Scale::kLinear, text), Contains(says));
}

TEST_CASE("a candidate is assignments for --set") {
  const std::vector<Parameter> parameters{parse_parameter(Scale::kLogarithmic, "a.b,a.c=1e4..1e6"),
                                          parse_parameter(Scale::kWhole, "a.d=1..5")};
  CHECK(assignments(parameters, Eigen::Vector2d(0.5, 1.0)) ==
        std::vector<std::string>{"a.b=100000", "a.c=100000", "a.d=5"});
}
