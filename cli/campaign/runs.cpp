#include "cli/campaign/runs.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "cli/campaign/files.hpp"
#include "cli/example/scenario.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "config/extends.hpp"
#include "config/scenario.hpp"
#include "config/show.hpp"
#include "controller/base/hash.hpp"

namespace c3rt::cli::campaign {
namespace fs = std::filesystem;
namespace {

std::string hash(const std::string& text) {
  base::Hash hash;
  hash.add(text);
  return hash.text();
}

/// What the programs are: another build may answer otherwise though its version is the same.
std::string programs() {
  std::string text = read_text(binary_directory() / "c3rt");
  for (const char* name : {"plant", "impedance", "planner", "vision"})
    text += read_text(process_directory() / (std::string("c3rt-") + name));
  return hash(text);
}

std::vector<std::string> overrides_of(const RunSpec& spec, bool is_example) {
  std::vector<std::string> all = spec.overrides;
  if (spec.duration) {
    all.push_back(fmt::format("{}={}", is_example ? "control.duration_s" : "task.duration_s",
                              *spec.duration));
  }
  return all;
}

/// After "c3rt run".
std::vector<std::string> words(const RunSpec& spec, const fs::path& file, bool is_example) {
  std::vector<std::string> all{file.string(), fmt::format("--seed={}", spec.seed)};
  if (!is_example) {
    if (spec.in_process) {
      all.emplace_back("--in-process");
    } else {
      all.insert(all.end(), {"--clock=lockstep", "--domain=any"});
    }
    if (!spec.logs) all.emplace_back("--no-logs");
    if (!spec.pictures) all.emplace_back("--no-pictures");
  }
  for (const std::string& assignment : overrides_of(spec, is_example))
    all.push_back("--set=" + assignment);
  return all;
}

/// The scenario is read here as well: a mistake ends the call before the first run.
void check(const fs::path& file, const std::vector<std::string>& overrides, bool is_example) {
  if (is_example) {
    load_example(file, overrides);
  } else {
    config::load_scenario(file.string(), overrides);
  }
}

struct Plan {
  RunResult result;
  ordered_json key;
  Job job;
};

std::optional<RunResult> kept(const Plan& plan) {
  const ordered_json note =
      ordered_json::parse(read_text(plan.result.folder / "run.json"), nullptr, false);
  if (!note.is_object() || note.value("key", ordered_json()) != plan.key) return std::nullopt;
  RunResult result = plan.result;
  result.report =
      ordered_json::parse(read_text(plan.result.folder / "report.json"), nullptr, false);
  if (!result.report.is_object()) return std::nullopt;
  result.status = note.at("status");
  result.wall_s = note.at("wall_s");
  result.kept = true;
  return result;
}

/// Takes what an ended job left.
void finish(Plan& plan, const JobEnd& end) {
  RunResult& result = plan.result;
  result.status = end.status;
  result.wall_s = end.wall_s;
  result.failure = end.failure;
  if (end.status != kDone && end.status != kCriterionFailed) {
    result.status = kProcessFailed;
    return;
  }
  result.report = ordered_json::parse(read_text(result.folder / "report.json"), nullptr, false);
  if (!result.report.is_object()) {
    result.status = kProcessFailed;
    result.report = nullptr;
    result.failure = plan.job.name + ": no report.json in " + result.folder.string();
    return;
  }
  // somebody ended this run alone: it is not what the seed gives
  if (result.report.value("result", "") == "interrupted") {
    result.status = kProcessFailed;
    result.failure = plan.job.name + " was interrupted by a signal";
    return;
  }
  const ordered_json note{{"key", plan.key}, {"status", end.status}, {"wall_s", end.wall_s}};
  write_text(result.folder / "run.json", note.dump(1) + "\n");
}

/// The line on the screen.
class Line {
 public:
  Line(const RunSettings& settings, std::size_t count, int kept)
      : progress_(settings.title), count_(count), done_(kept) {}
  void ended(const RunResult& result) {
    ++done_;
    ++made_;
    failed_ += result.status == kProcessFailed ? 1 : 0;
    missed_ += result.status == kCriterionFailed ? 1 : 0;
    wall_ += result.wall_s;
  }
  void look(int running) {
    // a running job counts for half: nobody knows how far it is
    const double left = static_cast<double>(count_) - done_;
    const double share = made_ == 0 ? 0.0 : made_ / (made_ + std::max(0.5, left - 0.5 * running));
    progress_.update(share, fmt::format("{} of {} done, {} running, {} missed criteria, {} failed",
                                        done_, count_, running, missed_, failed_));
  }

 private:
  Progress progress_;
  std::size_t count_;
  int done_, made_ = 0, failed_ = 0, missed_ = 0;
  double wall_ = 0.0;  // [s]
};

}  // namespace

std::vector<RunResult> run_all(const std::vector<RunSpec>& specs, const RunSettings& settings) {
  const std::string program = programs();
  std::map<std::string, std::string> scenarios;  // by file: the whole, with what it extends
  // of the objects that the whole names
  std::map<std::pair<std::string, std::vector<std::string>>, std::string> files_of;
  std::vector<Plan> plans;
  for (const RunSpec& spec : specs) {
    const fs::path file = scenario_path(spec.scenario);
    const bool example = is_example(file);
    if (example && spec.in_process) {
      throw UsageError("--in-process: " + spec.scenario +
                       " is a numerical example, which runs in one process anyway");
    }
    auto [whole, is_new] = scenarios.try_emplace(file.string());
    if (is_new) whole->second = hash(config::whole_scenario(file.string()));
    const std::vector<std::string> overrides = overrides_of(spec, example);
    if (plans.empty() || is_new || spec.overrides != plans.back().result.spec.overrides)
      check(file, overrides, example);
    auto [files, are_new] = files_of.try_emplace({file.string(), overrides});
    if (are_new) files->second = hash_of_files(config::load_composed(file.string(), overrides));
    Plan plan;
    plan.result.spec = spec;
    plan.result.spec.example = example;
    plan.result.folder = fs::absolute(settings.folder) / spec.name;
    plan.key = {{"scenario", whole->second},
                {"files", files->second},
                {"overrides", overrides},
                {"seed", spec.seed},
                {"logs", spec.logs},
                {"pictures", spec.pictures},
                {"in_process", spec.in_process},
                {"programs", program}};
    plan.job = {spec.name, words(spec, file, example), plan.result.folder};
    plans.push_back(plan);
  }

  std::vector<bool> have(plans.size(), false);
  std::vector<Job> jobs;
  std::vector<std::size_t> plan_of;  // by job
  for (std::size_t i = 0; i < plans.size(); ++i) {
    if (const auto result = settings.fresh ? std::nullopt : kept(plans[i])) {
      plans[i].result = *result;
      have[i] = true;
      continue;
    }
    make_folder(plans[i].result.folder);
    fs::remove(plans[i].result.folder / "run.json");
    fs::remove(plans[i].result.folder / "report.json");
    jobs.push_back(plans[i].job);
    plan_of.push_back(i);
  }

  if (!jobs.empty()) {
    Line line(settings, plans.size(), static_cast<int>(plans.size() - jobs.size()));
    const Watch watch{settings.stop,
                      [&](const JobEnd& end) {
                        Plan& plan = plans[plan_of[end.job]];
                        finish(plan, end);
                        have[plan_of[end.job]] = true;
                        line.ended(plan.result);
                      },
                      [&](int running) { line.look(running); }};
    settings.engine(jobs, std::max(1, settings.at_once), watch);
  }
  std::vector<RunResult> results;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    if (have[i]) results.push_back(std::move(plans[i].result));
  }
  return results;
}

std::string replay_command(const RunSpec& spec) {
  const char* how = spec.example ? "" : spec.in_process ? " --in-process" : " --clock lockstep";
  std::string text = "c3rt run " + spec.scenario + how + fmt::format(" --seed {}", spec.seed);
  if (spec.duration) text += fmt::format(" --duration {}", *spec.duration);
  for (const std::string& assignment : spec.overrides) {
    // what a shell would take apart
    const bool plain = assignment.find_first_of(" []{}*?'\"$&;|<>()#\\") == std::string::npos;
    text += " --set " + (plain ? assignment : "'" + assignment + "'");
  }
  return text;
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

}  // namespace c3rt::cli::campaign
