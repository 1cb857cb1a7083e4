#include "cli/report/figure.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/program.hpp"
#include "cli/python.hpp"

namespace c3rt::cli {
namespace {

using nlohmann::ordered_json;

constexpr double kPatience = 20.0, kPatienceEach = 5.0;  // for Python's start and for a picture [s]

/// Why no picture can be drawn; empty while they can.
std::string& unusable() {
  static std::string reason;
  return reason;
}

/// What is not finite becomes null.
ordered_json list_of(const Eigen::VectorXd& values) {
  return std::vector<double>(values.begin(), values.end());
}

ordered_json limits_of(const Limits& limits) { return {limits[0], limits[1]}; }

ordered_json json_of(const Curve& curve) {
  ordered_json json{{"name", curve.name},
                    {"x", list_of(curve.x)},
                    {"y", list_of(curve.y)},
                    {"width", curve.width},
                    {"mark_size", curve.mark_size},
                    {"marks", !curve.points ? "none" : curve.cross ? "cross" : "dot"}};
  if (!curve.color.empty()) json["color"] = curve.color;
  if (curve.dashed || !curve.joined) json["line"] = curve.joined ? "dashed" : "none";
  return json;
}

ordered_json json_of(const Shade& shade) {
  return {{"name", shade.name},
          {"color", shade.color},
          {"low", shade.low},
          {"high", shade.high},
          {"intervals", shade.intervals}};
}

ordered_json json_of(const Band& band) {
  return {{"name", band.name},
          {"color", band.color},
          {"x", list_of(band.x)},
          {"y", list_of(band.y)},
          {"radius", band.radius}};
}

ordered_json json_of(const Bars& bars) {
  return {
      {"color", bars.color}, {"edges", list_of(bars.edges)}, {"heights", list_of(bars.heights)}};
}

ordered_json json_of(const Polygon& polygon) {
  ordered_json json{{"name", polygon.name},
                    {"color", polygon.color},
                    {"x", list_of(polygon.x)},
                    {"y", list_of(polygon.y)}};
  if (!polygon.edge.empty()) json["edge"] = polygon.edge;
  return json;
}

ordered_json json_of(const Panel& panel);

template <typename Item>
ordered_json list_of(const std::vector<Item>& items) {
  ordered_json list = ordered_json::array();
  for (const Item& item : items) list.push_back(json_of(item));
  return list;
}

ordered_json json_of(const Panel& panel) {
  return {{"title", panel.title},
          {"x_label", panel.x_label},
          {"y_label", panel.y_label},
          {"y_scale", panel.logarithmic ? "log" : "linear"},
          {"x_limits", limits_of(panel.x_limits)},
          {"y_limits", limits_of(panel.y_limits)},
          {"equal", panel.equal},
          {"axes", panel.axes},
          {"legend", panel.legend_below ? "below" : "right"},
          {"curves", list_of(panel.curves)},
          {"shades", list_of(panel.shades)},
          {"bands", list_of(panel.bands)},
          {"bars", list_of(panel.bars)},
          {"polygons", list_of(panel.polygons)}};
}

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \n");
  if (end == std::string::npos) return "";
  const std::size_t before = text.rfind('\n', end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text.substr(begin, end + 1 - begin);
}

/// "no a.png, b.png: full; no c.png: …", neighbours with one reason together.
class Missing {
 public:
  void add(const std::filesystem::path& file, const std::string& reason) {
    if (reason != reason_) end();
    names_ += (names_.empty() ? "" : ", ") + file.filename().string();
    reason_ = reason;
  }
  std::string text() {
    end();
    return text_;
  }

 private:
  void end() {
    if (names_.empty()) return;
    text_ += fmt::format("{}no {}: {}", text_.empty() ? "" : "; ", names_, reason_);
    names_.clear();
  }
  std::string names_, reason_, text_;
};

/// Starts Python with the pictures. @return by file why it is missing
ordered_json drawn(const std::vector<Picture>& pictures, std::string& why) {
  const FoundPython python = find_python({"matplotlib"});
  if (python.program.empty()) {
    why = unusable() = python.missing;
    return {};
  }
  ordered_json list = ordered_json::array();
  for (const Picture& picture : pictures)
    list.push_back({{"file", picture.file.string()}, {"figure", to_json(picture.figure)}});
  // safe: from the working folder no module is taken
  const ProgramEnd end = run_program(
      {python.program, "-B", "-m", "c3rt.pictures"}, ordered_json{{"pictures", list}}.dump(),
      kPatience + kPatienceEach * static_cast<double>(pictures.size()),
      {"PYTHONPATH=" + package_path(), "PYTHONSAFEPATH=1"});
  const std::string said = last_line(end.output);
  const ordered_json answer = ordered_json::parse(said, nullptr, false);
  if (answer.is_object() && answer.contains("missing")) return answer["missing"];
  why = fmt::format("{} {}{}{}", python.program, end.reason, said.empty() ? "" : ": ", said);
  if (end.kind == ProgramEnd::Kind::kTimedOut) unusable() = why;
  return {};
}

}  // namespace

std::vector<std::pair<double, double>> intervals(const Eigen::VectorXd& times,
                                                 const Eigen::Array<bool, Eigen::Dynamic, 1>& on) {
  std::vector<std::pair<double, double>> found;
  for (Eigen::Index i = 0; i < on.size(); ++i) {
    if (!on[i]) continue;
    if (i > 0 && on[i - 1]) {
      found.back().second = times[i + 1];
    } else {
      found.emplace_back(times[i], times[i + 1]);
    }
  }
  return found;
}

ordered_json to_json(const Figure& figure) {
  ordered_json json{
      {"title", figure.title}, {"columns", figure.columns}, {"panels", list_of(figure.panels)}};
  if (figure.width > 0) json["size"] = {figure.width, figure.height};
  return json;
}

std::string draw(const std::vector<Picture>& pictures) {
  std::string why = unusable();
  const ordered_json missing = why.empty() ? drawn(pictures, why) : ordered_json();
  Missing all;
  for (const Picture& picture : pictures) {
    const auto named = missing.find(picture.file.string());
    if (why.empty() && named == missing.end()) continue;
    std::error_code error;  // what a killed process left
    std::filesystem::remove(picture.file.string() + ".part", error);
    all.add(picture.file, why.empty() ? named->get<std::string>() : why);
  }
  return all.text();
}

}  // namespace c3rt::cli
