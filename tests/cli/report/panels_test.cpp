#include "cli/report/panels.hpp"

#include <limits>

#include <catch2/catch.hpp>

#include "tests/cli/folder.hpp"

using namespace c3rt::cli;
using Eigen::VectorXd;

TEST_CASE("intervals: neighbours are one interval, and the last one ends with the last time") {
  const VectorXd times = VectorXd::LinSpaced(7, 0.0, 6.0);
  Eigen::Array<bool, Eigen::Dynamic, 1> on(6);
  on << true, true, false, true, false, true;
  const std::vector<std::pair<double, double>> expected{{0, 2}, {3, 4}, {5, 6}};
  CHECK(intervals(times, on) == expected);
  on.setConstant(false);
  CHECK(intervals(times, on).empty());
}

TEST_CASE("a picture is drawn of curves with gaps, of shades alone, and of nothing") {
  const Folder folder;
  const VectorXd x = VectorXd::LinSpaced(4, 0.0, 3.0);
  VectorXd y = x;
  y[2] = std::numeric_limits<double>::quiet_NaN();
  const VectorXd nothing = VectorXd::Constant(4, y[2]);
  const std::vector<Panel> panels{
      {"gaps", "x", "y", {{"a", "#000000", x, y}, {"b", "#ff0000", x, x, true, true}}},
      {"logarithmic",
       "x",
       "y",
       {{"it's \"quoted\"", "#000000", x, (x.array() + 1.0).matrix()}},
       {},
       true},
      {"shade", "x", "y", {}, {{"on", "#cfe0fa", 0.5, 1.0, {{0.2, 0.4}}}}},
      {"all gaps", "x", "y", {{"c", "#000000", x, nothing}}},
      {"empty", "x", "y", {}}};
  CHECK(draw_panels(folder.path() / "panels.png", "five", panels) == "");
  CHECK(std::filesystem::file_size(folder.path() / "panels.png") > 1000);
}

TEST_CASE("a picture that cannot be written is named") {
  CHECK_THAT(draw_panels("/no/such/folder/x.png", "none", {{"", "", "", {}}}),
             Catch::Contains("x.png"));
}
