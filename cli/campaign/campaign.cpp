#include "cli/campaign/campaign.hpp"

#include <cstdio>

#include <fmt/format.h>

#include "cli/campaign/runs.hpp"
#include "cli/campaign/seeds.hpp"
#include "cli/campaign/table.hpp"
#include "cli/exit_status.hpp"
#include "cli/paths.hpp"

namespace c3rt::cli::campaign {
namespace fs = std::filesystem;
namespace {

std::vector<RunSpec> specs(const Settings& settings) {
  std::vector<RunSpec> all;
  for (const std::uint64_t seed : parse_seeds(settings.seeds)) {
    all.push_back({fmt::format("seed-{:04}", seed), settings.scenario, seed, settings.overrides,
                   settings.duration, settings.logs, settings.pictures, settings.in_process});
  }
  return all;
}

std::string markdown(const Settings& settings, const Summary& summary,
                     const std::vector<RunResult>& results) {
  std::string text = fmt::format("# Campaign {}, seeds {}\n\n", settings.scenario, settings.seeds);
  if (!settings.overrides.empty()) {
    text += "Overrides:";
    for (const std::string& assignment : settings.overrides) text += " `" + assignment + "`";
    text += "\n\n";
  }
  text += verdict(summary) + ".\n\n" + markdown_table(rows(summary)) + "\n";
  text += "The worst run again: `" + replay_command(results[summary.worst].spec) + "`\n";
  return text;
}

}  // namespace

int run(const Settings& settings, const Stop& stop) {
  RunSettings how = run_settings(settings, stop);
  how.title = "campaign " + settings.scenario;
  const std::vector<RunSpec> wanted = specs(settings);
  const std::string name = scenario_path(settings.scenario).stem().string();
  how.folder = make_folder(settings.out.empty() ? fs::path("out") / ("campaign-" + name)
                                                : fs::path(settings.out));
  fmt::print("c3rt campaign {}: {} runs, {} at once, in {}\n", name, wanted.size(), how.at_once,
             how.folder.string());
  std::fflush(stdout);

  const std::vector<RunResult> results = run_all(wanted, how);
  const auto kept = std::count_if(results.begin(), results.end(),
                                  [](const RunResult& result) { return result.kept; });
  if (kept > 0) fmt::print("{} runs of an earlier call are kept\n", kept);
  for (const RunResult& result : results) {
    if (result.status == kProcessFailed) fmt::print(stderr, "c3rt: error: {}\n", result.failure);
  }
  const bool interrupted = results.size() < wanted.size();
  if (interrupted) {
    fmt::print(stderr, "interrupted after {} of {} runs; the same command goes on from there\n",
               results.size(), wanted.size());
  }
  if (results.empty()) return kCriterionFailed;

  const Summary summary = summarise(results);
  ordered_json json{{"scenario", name},
                    {"seeds", settings.seeds},
                    {"overrides", settings.overrides},
                    {"complete", !interrupted}};
  json.update(to_json(summary, results));
  write_text(how.folder / "campaign.json", json.dump(1) + "\n");
  write_text(how.folder / "campaign.md", markdown(settings, summary, results));
  fmt::print("\n{}\n{}: {}\n", text_table(rows(summary)), name, verdict(summary));
  fmt::print("  {:<16}{}\n  {:<16}{}\n", "worst run again",
             replay_command(results[summary.worst].spec), "results in", how.folder.string());
  if (summary.failed > 0) return kProcessFailed;
  return interrupted || summary.missed > 0 ? kCriterionFailed : kDone;
}

}  // namespace c3rt::cli::campaign
