#include "config/process_options.hpp"

#include <map>

#include <CLI/CLI.hpp>

namespace c3rt::config {

std::optional<ProcessOptions> parse_process_options(int argc, char** argv, const std::string& name,
                                                    const std::string& description,
                                                    int& exit_status) {
  ProcessOptions options;
  CLI::App app{description, name};
  app.footer(
      "Example:\n  " + name +
      " config/scenarios/circle_slow.yaml --clock realtime --dds-profile config/dds/loopback.xml\n"
      "A person usually starts all processes together: c3rt run circle_slow");
  app.add_option("scenario", options.scenario_path, "Scenario file (config/scenarios/*.yaml)")
      ->required();
  app.add_option("--set", options.overrides, "Override one key of the scenario: section.key=value")
      ->take_all();
  const std::map<std::string, Clock> clocks{{"realtime", Clock::kRealtime},
                                            {"lockstep", Clock::kLockstep}};
  app.add_option("--clock", options.clock, "realtime or lockstep")
      ->transform(CLI::CheckedTransformer(clocks));
  app.add_option("--seed", options.seed, "Seed of every random number of the run");
  app.add_option("--session", options.session, "Session id; 0: the plant draws one");
  app.add_option("--domain", options.domain, "DDS domain")->check(CLI::Range(0, 230));
  app.add_option("--dds-profile", options.dds_profile, "DDS profile (config/dds/*.xml)");
  app.add_option("--expect", options.expect, "Lockstep: processes that must join (plant only)")
      ->delimiter(',');
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_status = app.exit(error) == 0 ? kStopped : kCouldNotStart;
    return std::nullopt;
  }
  return options;
}

}  // namespace c3rt::config
