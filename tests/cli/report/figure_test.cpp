#include "cli/report/figure.hpp"

#include <fstream>
#include <limits>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/folder.hpp"

using namespace c3rt::cli;
using Catch::Contains;
using Eigen::VectorXd;

namespace {

/// Of everything that a figure may have.
Figure everything() {
  const VectorXd x = VectorXd::LinSpaced(4, 0.0, 3.0);
  VectorXd y = x;
  y[2] = std::numeric_limits<double>::quiet_NaN();
  Panel seen{"seen", "x", "y", {{"marks", "", x, x, false, true, false, true, 1.0, 6.0}}};
  seen.bands = {{"band", "#f8cfdc", x, x, 0.2}};
  seen.polygons = {{"area", "#0000ff", "#000000", x.head(3), x.head(3)}};
  seen.equal = true;
  seen.axes = false;
  seen.legend_below = true;
  Panel bars{"bars", "x", "y", {}};
  bars.bars = {{"#ff0000", x, x.head(3)}};
  bars.x_limits = {0.5, kNone};
  return {"every kind",
          {{"gaps", "x", "y", {{"a", "#000000", x, y}, {"b", "#ff0000", x, x, true, true}}},
           {"logarithmic",
            "x",
            "y",
            {{"it's \"quoted\"", "", x, (x.array() + 1.0).matrix()}},
            {},
            true},
           {"shade", "x", "y", {}, {{"on", "#cfe0fa", 0.5, 1.0, {{0.2, 0.4}}}}},
           {"all gaps", "x", "y", {{"c", "#000000", x, VectorXd::Constant(4, y[2])}}},
           seen,
           bars},
          2};
}

}  // namespace

TEST_CASE("intervals: neighbours are one interval, and the last one ends with the last time") {
  const VectorXd times = VectorXd::LinSpaced(7, 0.0, 6.0);
  Eigen::Array<bool, Eigen::Dynamic, 1> on(6);
  on << true, true, false, true, false, true;
  const std::vector<std::pair<double, double>> expected{{0, 2}, {3, 4}, {5, 6}};
  CHECK(intervals(times, on) == expected);
  on.setConstant(false);
  CHECK(intervals(times, on).empty());
}

TEST_CASE("figure: as JSON a gap is null, as an open limit is, and what has no colour gets one") {
  const nlohmann::ordered_json json = nlohmann::ordered_json::parse(to_json(everything()).dump());
  const auto& curve = json["panels"][0]["curves"][0];
  CHECK(curve["y"].dump() == "[0.0,1.0,null,3.0]");
  CHECK(curve["color"] == "#000000");
  CHECK(json["panels"][0]["curves"][1]["line"] == "dashed");
  CHECK(json["panels"][1]["y_scale"] == "log");
  CHECK_FALSE(json["panels"][1]["curves"][0].contains("color"));
  CHECK(json["panels"][5]["x_limits"].dump() == "[0.5,null]");
  CHECK_FALSE(json.contains("size"));
}

TEST_CASE("figure: Python knows every key, and draws all pictures of one call") {
  const Folder folder;
  Figure sized = everything();
  sized.width = 640;
  sized.height = 480;
  CHECK(draw({{folder.path() / "a.png", everything()}, {folder.path() / "b.png", sized}}) == "");
  for (const char* name : {"a.png", "b.png"})
    CHECK(std::filesystem::file_size(folder.path() / name) > 1000);
}

TEST_CASE("figure: what lies in the working folder is not taken for a module of Python") {
  const Folder folder;
  std::ofstream(folder.path() / "json.py") << "raise SystemExit(5)\n";
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const std::string said = draw({{folder.path() / "a.png", {"", {{"", "", "", {}}}}}});
  std::filesystem::current_path(before);
  CHECK(said == "");
}

TEST_CASE("figure: what is missing is named with its reason, and the others are there") {
  const Folder folder;
  const Figure empty{"empty", {{"", "", "", {}}}};
  Figure wrong = empty;
  wrong.panels[0].curves = {{"", "red", {}, {}}};
  const std::string said = draw({{"/no/such/folder/x.png", empty},
                                 {"/no/such/folder/y.png", empty},
                                 {folder.path() / "a.png", empty},
                                 {folder.path() / "b.png", wrong}});
  CHECK(said ==
        "no x.png, y.png: could not write the file: No such file or directory; no b.png: "
        "panels[0].curves[0].color: expected a colour, #rrggbb, got 'red'");
  CHECK(std::filesystem::exists(folder.path() / "a.png"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "b.png"));
}
