#include "cli/reproduce/runs.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <sys/wait.h>

#include "cli/evaluation.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "cli/supervisor.hpp"

namespace c3rt::cli::reproduce {
namespace fs = std::filesystem;
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);
constexpr double kGrace = 30.0;  // the runs end first [s]

ordered_json order_of(const RunSpec& spec) {
  return {{"name", spec.name},
          {"scenario", spec.scenario},
          {"seeds", spec.seeds},
          {"overrides", spec.overrides},
          {"duration", spec.duration ? ordered_json(*spec.duration) : ordered_json()},
          {"logs", spec.logs},
          {"in_process", spec.in_process}};
}

/// Waits for the package's program to end. @return its exit status
int outcome_of(const std::vector<std::string>& words, const Stop& stop) {
  ChildSpec child{"c3rt.evaluation", {"/usr/bin/env"}, {}};
  child.arguments.insert(child.arguments.end(), words.begin(), words.end());
  Supervisor supervisor;
  supervisor.start(child);
  while (!stop()) {
    if (const auto ended = supervisor.poll()) {
      if (WIFEXITED(ended->status)) return WEXITSTATUS(ended->status);
      throw std::runtime_error(ended->name + " " + ended->reason);
    }
    std::this_thread::sleep_for(kLook);
  }
  supervisor.stop(kGrace);
  throw Interrupted{};
}

RunGroup group_of(const RunSpec& spec, const ordered_json& told) {
  RunGroup group{{}, told.at("summary")};
  for (const ordered_json& run : told.at("runs")) {
    group.runs.push_back(
        {spec, run.at("folder").get<std::string>(), run.at("report"), run.at("command")});
  }
  return group;
}

}  // namespace

std::vector<RunGroup> run_all(const std::vector<RunSpec>& specs, const RunSettings& settings) {
  ordered_json groups = ordered_json::array();
  for (const RunSpec& spec : specs) groups.push_back(order_of(spec));
  const fs::path answer = make_folder(settings.folder) / ("." + settings.title + ".json");
  const ordered_json order{{"program", (binary_directory() / "c3rt").string()},
                           {"fresh", settings.fresh},
                           {"folder", settings.folder.string()},
                           {"title", settings.title},
                           {"groups", groups},
                           {"answer", answer.string()}};
  const int status =
      outcome_of(evaluation_words("c3rt reproduce", {}, "groups", order), settings.stop);
  if (status == kCriterionFailed) throw Interrupted{};
  if (status != kDone) throw NoRuns{status};
  const ordered_json told = ordered_json::parse(read_text(answer));
  fs::remove(answer);
  std::vector<RunGroup> all;
  for (std::size_t i = 0; i < specs.size(); ++i) all.push_back(group_of(specs[i], told.at(i)));
  return all;
}

std::vector<std::vector<std::string>> read_cells(const fs::path& file,
                                                 const std::vector<std::string>& names) {
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) throw std::runtime_error("cannot read " + file.string());
  const auto split = [](const std::string& text) {
    std::vector<std::string> words;
    for (std::size_t from = 0; from <= text.size();) {
      const std::size_t comma = std::min(text.find(',', from), text.size());
      words.push_back(text.substr(from, comma - from));
      from = comma + 1;
    }
    return words;
  };
  const std::vector<std::string> head = split(line);
  std::vector<std::size_t> columns;
  for (const std::string& name : names) {
    const auto found = std::find(head.begin(), head.end(), name);
    if (found == head.end())
      throw std::runtime_error(file.string() + ": there is no column \"" + name + "\"");
    columns.push_back(static_cast<std::size_t>(found - head.begin()));
  }
  std::vector<std::vector<std::string>> rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> words = split(line);
    if (words.size() != head.size())
      throw std::runtime_error(fmt::format("{}: row {} has {} columns, expected {}", file.string(),
                                           rows.size() + 1, words.size(), head.size()));
    std::vector<std::string> row;
    for (const std::size_t column : columns) row.push_back(words[column]);
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::vector<double>> read_columns(const fs::path& file,
                                              const std::vector<std::string>& names) {
  std::vector<std::vector<double>> rows;
  for (const std::vector<std::string>& cells : read_cells(file, names)) {
    std::vector<double>& row = rows.emplace_back();
    for (const std::string& cell : cells) row.push_back(std::strtod(cell.c_str(), nullptr));
  }
  return rows;
}

}  // namespace c3rt::cli::reproduce
