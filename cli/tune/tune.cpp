#include "cli/tune/tune.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/campaign/python.hpp"
#include "cli/campaign/runs.hpp"
#include "cli/campaign/seeds.hpp"
#include "cli/campaign/statistics.hpp"
#include "cli/campaign/table.hpp"
#include "cli/example/scenario.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"
#include "cli/tune/optimiser.hpp"
#include "cli/tune/score.hpp"
#include "cli/tune/search.hpp"
#include "config/extends.hpp"
#include "config/override.hpp"
#include "config/show.hpp"

namespace c3rt::cli::tune {
namespace fs = std::filesystem;
namespace {

using campaign::ordered_json;
using campaign::RunResult;
using campaign::RunSpec;

std::vector<Parameter> parameters_of(const Settings& settings) {
  std::vector<Parameter> all;
  for (const auto& [scale, texts] : {std::pair{Scale::kLinear, &settings.linear},
                                     {Scale::kLogarithmic, &settings.log},
                                     {Scale::kWhole, &settings.whole}}) {
    for (const std::string& text : *texts) all.push_back(parse_parameter(scale, text));
  }
  if (all.size() < 2) {
    throw UsageError(fmt::format(
        "expected two numbers to look for or more (--linear, --log, --whole), got {}: of one, c3rt "
        "campaign with some values of --set tells as much",
        all.size()));
  }
  return all;
}

void require_other_seeds(const Settings& settings) {
  const std::vector<std::uint64_t> tuning = campaign::parse_seeds(settings.seeds);
  for (const std::uint64_t seed : campaign::parse_seeds(settings.test_seeds)) {
    if (std::find(tuning.begin(), tuning.end(), seed) != tuning.end()) {
      throw UsageError(fmt::format(
          "--test-seeds: expected seeds that are not among --seeds, got {} in both: what was "
          "chosen on a seed proves nothing there",
          seed));
    }
  }
}

/// What was tried, and how good it is.
struct Candidate {
  Eigen::VectorXd unit;
  Score score;
};

class Tuner {
 public:
  Tuner(const Settings& settings, Stop stop)
      : settings_(settings),
        stop_(std::move(stop)),
        parameters_(parameters_of(settings)),
        file_(scenario_path(settings.scenario)),
        name_(file_.stem().string()),
        is_example_(is_example(file_)),
        python_(campaign::python_with("c3rt tune", "cmaes", "cmaes")) {
    if (settings.minimise.empty() == settings.maximise.empty())
      throw UsageError("expected --minimise FIGURE or --maximise FIGURE, got both or none");
    (void)campaign::run_settings(settings, stop_);  // refuses before anything is started
    require_other_seeds(settings);
    const config::Tree tree = config::load_composed(file_.string(), settings.overrides);
    search_ = {start(parameters_, tree, file_.string()), settings.sigma, settings.seed,
               settings.population > 0 ? settings.population
                                       : usual_population(static_cast<int>(parameters_.size()))};
    folder_ = make_folder(settings.out.empty() ? fs::path("out") / ("tune-" + name_)
                                               : fs::path(settings.out));
  }

  int run() {
    fmt::print("c3rt tune {}: {} numbers, {} generations of {}, seeds {}, in {}\n", name_,
               parameters_.size(), settings_.generations, search_.population, settings_.seeds,
               folder_.string());
    std::fflush(stdout);
    const auto first = judge("start", {search_.mean}, settings_.seeds);
    if (!first) return interrupted(0);
    start_ = best_ = first->front();
    if (start_.score.failed > 0) return kProcessFailed;
    tell("start", start_.score);
    for (int number = 1; number <= settings_.generations; ++number) {
      const std::vector<Eigen::VectorXd> units = next_candidates(python_, search_, history_);
      const auto candidates =
          judge(fmt::format("generation {} of {}", number, settings_.generations), units,
                settings_.seeds, fmt::format("g{:03}-c", number));
      if (!candidates) return interrupted(number);
      take(*candidates);
      tell(fmt::format("generation {}", number), best_.score);
      write(nullptr);
    }
    const auto tested = judge("test", {start_.unit, best_.unit}, settings_.test_seeds, "test-");
    if (!tested) return interrupted(settings_.generations + 1);
    return end((*tested)[0].score, (*tested)[1].score);
  }

 private:
  const std::string& figure() const {
    return settings_.minimise.empty() ? settings_.maximise : settings_.minimise;
  }
  bool more_is_better() const { return settings_.minimise.empty(); }
  std::string text(const Score& score) const {
    return tune::text(score, figure(), more_is_better());
  }
  void tell(const std::string& what, const Score& score) const {
    fmt::print("  {:<16}{}\n", what, text(score));
    std::fflush(stdout);
  }

  std::vector<std::string> overrides(const Eigen::VectorXd& unit) const {
    std::vector<std::string> all = settings_.overrides;
    for (const std::string& assignment : assignments(parameters_, unit)) all.push_back(assignment);
    return all;
  }

  /// Every seed of every candidate, as one set of runs. @return nothing where it was interrupted
  /// @param prefix of the runs' folders
  std::optional<std::vector<Candidate>> judge(const std::string& title,
                                              const std::vector<Eigen::VectorXd>& units,
                                              const std::string& seeds,
                                              const std::string& prefix = "start-") {
    campaign::RunSettings how = campaign::run_settings(settings_, stop_);
    how.folder = folder_;
    how.title = "tune " + name_ + ", " + title;
    const std::vector<std::uint64_t> numbers = campaign::parse_seeds(seeds);
    std::vector<RunSpec> specs;
    for (std::size_t i = 0; i < units.size(); ++i) {
      for (const std::uint64_t seed : numbers) {
        specs.push_back({fmt::format("{}{:02}-seed-{:04}", prefix, i + 1, seed), settings_.scenario,
                         seed, overrides(units[i]), settings_.duration, false, false,
                         !is_example_});
      }
    }
    const std::vector<RunResult> results = campaign::run_all(specs, how);
    if (results.size() < specs.size()) return std::nullopt;
    require_figure(results);
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < units.size(); ++i) {
      const auto first = results.begin() + static_cast<std::ptrdiff_t>(i * numbers.size());
      const std::vector<RunResult> own(first, first + static_cast<std::ptrdiff_t>(numbers.size()));
      for (const RunResult& result : own) {
        if (result.status == kProcessFailed)
          fmt::print(stderr, "c3rt: error: {}\n", result.failure);
      }
      candidates.push_back({units[i], score(own, figure(), more_is_better())});
    }
    return candidates;
  }

  /// A name that no report has is a mistake; a figure that one run does not reach is none.
  void require_figure(const std::vector<RunResult>& results) const {
    std::vector<std::string> names;
    for (const RunResult& result : results) {
      if (result.report.is_null()) continue;
      for (const auto& [name, value] : campaign::figures(result.report)) {
        if (name == figure()) return;
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
    }
    if (names.empty() || !history_.empty()) return;
    throw UsageError(fmt::format("{}: expected a figure of report.json, got {}; there are {}",
                                 more_is_better() ? "--maximise" : "--minimise", figure(),
                                 fmt::join(names, ", ")));
  }

  void take(const std::vector<Candidate>& candidates) {
    std::vector<Score> scores;
    Generation generation;
    for (const Candidate& candidate : candidates) {
      scores.push_back(candidate.score);
      generation.candidates.push_back(candidate.unit);
      if (candidate.score < best_.score) best_ = candidate;
    }
    generation.ranks = ranks(scores);
    history_.push_back(generation);
    scores_.push_back(scores);
  }

  int interrupted(int generation) const {
    fmt::print(stderr, "interrupted {}; the same command goes on from there\n",
               generation == 0                      ? "at the start"
               : generation > settings_.generations ? "on the test seeds"
                                                    : fmt::format("in generation {}", generation));
    return kCriterionFailed;
  }

  ordered_json json_of(const Score& score) const {
    ordered_json json{{"failed", score.failed}, {"shortfall", score.shortfall}};
    json[figure()] = more_is_better() ? -score.figure : score.figure;
    return json;
  }

  void write(const ordered_json& test) const {
    ordered_json generations = ordered_json::array();
    for (std::size_t g = 0; g < history_.size(); ++g) {
      ordered_json candidates = ordered_json::array();
      for (std::size_t i = 0; i < history_[g].candidates.size(); ++i) {
        ordered_json candidate = json_of(scores_[g][i]);
        candidate["values"] = assignments(parameters_, history_[g].candidates[i]);
        candidates.push_back(candidate);
      }
      generations.push_back(candidates);
    }
    const ordered_json json{{"scenario", name_},
                            {"overrides", settings_.overrides},
                            {"seeds", settings_.seeds},
                            {"test_seeds", settings_.test_seeds},
                            {"figure", figure()},
                            {"start", json_of(start_.score)},
                            {"best", json_of(best_.score)},
                            {"best_values", assignments(parameters_, best_.unit)},
                            {"test", test},
                            {"generations", generations}};
    write_text(folder_ / "tune.json", json.dump(1) + "\n");
  }

  /// The scenario whole, with what was found.
  void write_scenario(const fs::path& file) const {
    std::vector<std::string> all = overrides(best_.unit);
    all.push_back("name=" + name_ + "_tuned");
    write_text(file,
               config::show(config::load_composed(file_.string(), all), config::Comments::kNone));
  }

  int end(const Score& start, const Score& found) const {
    const fs::path file = folder_ / (name_ + "_tuned.yaml");
    write_scenario(file);
    const bool is_better = !(start < found);
    write({{"start", json_of(start)}, {"found", json_of(found)}, {"at_least_as_good", is_better}});
    const Rows rows{{"", "seeds " + settings_.seeds, "test seeds " + settings_.test_seeds},
                    {"start", text(start_.score), text(start)},
                    {"found", text(best_.score), text(found)}};
    std::string values;
    for (const std::string& value : assignments(parameters_, best_.unit))
      values += "- `" + value + "`\n";
    write_text(folder_ / "tune.md",
               fmt::format("# c3rt tune {}\n\n{}\n{}", name_, markdown_table(rows), values));
    fmt::print("\n{}\n", text_table(rows));
    for (const std::string& value : assignments(parameters_, best_.unit))
      fmt::print("  {}\n", value);
    fmt::print("{}: {} than the start on seeds that it was not chosen on\n  {:<16}{}\n", name_,
               is_better ? "no worse" : "worse", "scenario", file.string());
    return is_better ? kDone : kCriterionFailed;
  }

  const Settings& settings_;
  Stop stop_;
  std::vector<Parameter> parameters_;
  fs::path file_;
  std::string name_;
  bool is_example_;
  std::string python_;
  Search search_{};
  fs::path folder_;
  Candidate start_{}, best_{};
  std::vector<Generation> history_;
  std::vector<std::vector<Score>> scores_;  // of the generations
};

}  // namespace

int run(const Settings& settings, const Stop& stop) { return Tuner(settings, stop).run(); }

}  // namespace c3rt::cli::tune
