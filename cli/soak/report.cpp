#include "cli/soak/report.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/report/figure.hpp"

namespace c3rt::cli::soak {
namespace {

using invariants::ProcessSample;
using invariants::Violation;
using invariants::Violations;
using nlohmann::ordered_json;
using Courses = std::map<std::string, invariants::Processes::Course>;

constexpr double kMiB = 1024.0 * 1024.0, kKiB = 1024.0;
constexpr std::size_t kMostShown = 10;

ordered_json to_json(const Violation& violation) {
  return {{"name", violation.name},   {"subject", violation.subject}, {"time_s", violation.time},
          {"value", violation.value}, {"limit", violation.limit},     {"unit", violation.unit},
          {"pass", violation.pass},   {"seed", violation.seed}};
}

ordered_json to_json(const ProcessSample& sample) {
  return {{"memory_bytes", sample.memory},
          {"threads", sample.threads},
          {"descriptors", sample.descriptors}};
}

double grown(const invariants::Processes::Course& course) {
  return static_cast<double>(course.newest.memory) - static_cast<double>(course.at_settling.memory);
}

}  // namespace

void say_end(const std::string& text, const std::string& missing, const std::filesystem::path& out,
             const std::string& failure) {
  fmt::print("\n{}", text);
  if (!missing.empty()) fmt::print(stderr, "c3rt: {}\n", missing);
  fmt::print("  {:<12}{}\n", "report", out.string());
  std::fflush(stdout);
  if (!failure.empty()) fmt::print(stderr, "c3rt: error: {}\n", failure);
}

std::string time_text(double seconds) {
  if (seconds < 120.0) return fmt::format("{:.1f} s", seconds);
  if (seconds < 7200.0) return fmt::format("{:.1f} min", seconds / 60.0);
  return fmt::format("{:.2f} h", seconds / 3600.0);
}

void Thinned::add(double x, double y) {
  if (count_++ % every_ != 0) return;
  points_.emplace_back(x, y);
  if (points_.size() < kMost) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points_.size(); i += 2) points_[kept++] = points_[i];
  points_.resize(kept);
  every_ *= 2;
}

ordered_json to_json(const Violations& violations) {
  ordered_json by_name = ordered_json::object(), first = ordered_json::array();
  for (const auto& [name, count] : violations.counts()) by_name[name] = count;
  for (const Violation& violation : violations.kept()) first.push_back(to_json(violation));
  return {{"count", violations.count()}, {"by_name", by_name}, {"first", first}};
}

ordered_json to_json(const Courses& courses) {
  ordered_json processes = ordered_json::array();
  for (const auto& [name, course] : courses) {
    ordered_json process{{"name", name},
                         {"pid", course.pid},
                         {"watched_s", course.last - course.first},
                         {"at_first", to_json(course.at_first)},
                         {"at_5_min", nullptr},
                         {"largest", to_json(course.largest)},
                         {"at_end", to_json(course.newest)},
                         {"memory_grown_bytes", nullptr},
                         {"log_bytes", course.logged}};
    if (course.settled) {
      process["at_5_min"] = to_json(course.at_settling);
      process["memory_grown_bytes"] = grown(course);
    }
    processes.push_back(process);
  }
  return processes;
}

ordered_json to_json(const Summary& summary, const Violations& violations, const Courses& courses) {
  return {{"scenario", summary.scenario},
          {"clock", summary.clock},
          {"seed", summary.seed},
          {"result", summary.result},
          {"soaked_s", summary.soaked},
          {"wall_s", summary.wall},
          {"passes", {{"begun", summary.passes}, {"whole", summary.whole}, {"met", summary.met}}},
          {"samples", summary.samples},
          {"reflexes", summary.reflexes},
          {"violations", to_json(violations)},
          {"reproduce", summary.again},
          {"processes", to_json(courses)}};
}

std::string to_text(const Summary& summary, const Violations& violations, const Courses& courses) {
  std::string text = fmt::format("c3rt soak {} ({}, seed {}): {}\n", summary.scenario,
                                 summary.clock, summary.seed, summary.result);
  const auto line = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:<12}{}\n", name, value);
  };
  line("soaked",
       fmt::format("{} in {} of the wall", time_text(summary.soaked), time_text(summary.wall)));
  line("passes", fmt::format("{} begun, {} whole, {} met their criteria", summary.passes,
                             summary.whole, summary.met));
  line("samples", fmt::format("{} looked at, {} reflexes", summary.samples, summary.reflexes));
  for (const auto& [name, course] : courses) {
    std::string memory =
        fmt::format("{:.1f} MiB", static_cast<double>(course.newest.memory) / kMiB);
    memory += course.settled ? fmt::format(", {:+.0f} KiB since 5 minutes (at most {:+.0f})",
                                           grown(course) / kKiB,
                                           (static_cast<double>(course.largest.memory) -
                                            static_cast<double>(course.at_settling.memory)) /
                                               kKiB)
                             : ", not watched for 5 minutes";
    line(name.c_str(), fmt::format("{}; {} threads, {} descriptors, log {:.1f} KiB", memory,
                                   course.newest.threads, course.newest.descriptors,
                                   static_cast<double>(course.logged) / kKiB));
  }
  text += to_text(violations);
  for (const std::string& command : summary.again) line("again by", command);
  return text;
}

std::string to_text(const Violations& violations) {
  if (violations.count() == 0) return fmt::format("  {:<12}none\n", "violations");
  std::string names;
  for (const auto& [name, count] : violations.counts())
    names += fmt::format("{}{} {}", names.empty() ? "" : ", ", count, name);
  std::string text = fmt::format("  {:<12}{}: {}\n", "VIOLATIONS", violations.count(), names);
  for (std::size_t i = 0; i < std::min(kMostShown, violations.kept().size()); ++i)
    text += "    " + describe(violations.kept()[i]) + "\n";
  if (violations.count() > kMostShown) text += "    … the JSON report has more\n";
  return text;
}

Files::File Files::made(const std::filesystem::path& path, const char* head) {
  File file(std::fopen(path.c_str(), "we"));
  // by lines, so that it can be looked at while the soak goes on
  if (file) std::setvbuf(file.get(), nullptr, _IOLBF, 1 << 12);
  if (!file || std::fputs(head, file.get()) < 0)
    throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(errno));
  return file;
}

Files::Files(const std::filesystem::path& folder, bool of_passes)
    : passes_(of_passes
                  ? made(folder / "passes.csv",
                         "pass,seed,duration_s,loops_completed,whole,met,violations,log_hash\n")
                  : nullptr),
      processes_(made(folder / "processes.csv",
                      "time_s,process,pid,memory_bytes,threads,descriptors,log_bytes\n")) {}

/// What there is no room for is counted, and said once.
void Files::put(std::FILE* file, const std::string& line) {
  std::clearerr(file);
  // what is left in its buffer comes with the next line
  const bool written = std::fputs(line.c_str(), file) >= 0 && std::ferror(file) == 0;
  if (!written && lost_++ == 0)
    fmt::print(stderr, "c3rt: no room is left for passes.csv and processes.csv: lines are lost\n");
}

void Files::add(const Pass& pass) {
  put(passes_.get(),
      fmt::format("{},{},{:.3f},{},{:d},{:d},{},{}\n", pass.number, pass.seed, pass.duration,
                  pass.loops, pass.whole, pass.met, pass.violations, pass.log_hash));
}

void Files::add(double time, const ProcessSample& sample) {
  put(processes_.get(), fmt::format("{:.3f},{},{},{},{},{},{}\n", time, sample.name, sample.pid,
                                    sample.memory, sample.threads, sample.descriptors, sample.log));
  if (sample.pid != 0) memory_[sample.name].add(time, static_cast<double>(sample.memory) / kMiB);
}

std::string draw_memory(const std::filesystem::path& folder, const std::string& title,
                        const std::map<std::string, Thinned>& memory) {
  std::vector<Panel> panels;
  for (const auto& [name, thinned] : memory) {
    Curve curve;
    const auto count = static_cast<Eigen::Index>(thinned.points().size());
    curve.x.resize(count);
    curve.y.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto& [x, y] = thinned.points()[static_cast<std::size_t>(i)];
      curve.x[i] = x / 60.0;
      curve.y[i] = y;
    }
    Panel panel;
    panel.title = name;
    panel.x_label = "time [min]";
    panel.y_label = "memory [MiB]";
    panel.curves.push_back(curve);
    panels.push_back(panel);
  }
  if (panels.empty()) return "";
  return draw({{folder / "memory.png", {title, panels}}});
}

}  // namespace c3rt::cli::soak
