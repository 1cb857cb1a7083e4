#include "cli/recorded.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/paths.hpp"
#include "config/extends.hpp"
#include "config/section.hpp"
#include "config/show.hpp"

namespace c3rt::cli {

void tell(Recording& recording, const Recorded& of) {
  recording.add_metadata(kRunMetadata, {{"scenario", of.scenario},
                                        {"file", of.file},
                                        {"overrides", nlohmann::json(of.overrides).dump()},
                                        {"seed", std::to_string(of.seed)},
                                        {"clock", of.clock}});
  recording.attach(
      kScenarioAttachment, "application/yaml",
      config::show(config::load_composed(of.file, of.overrides), config::Comments::kNone));
}

/// What is wrong with a recording.
void tell_of(const Contents& contents, const std::string& file) {
  if (!contents.ending.whole)
    fmt::print(stderr, "c3rt: {}: {}; what came before is used\n", file, contents.ending.why);
  for (const auto& [topic, count] : contents.refused)
    fmt::print(stderr, "c3rt: {}: {} messages of {} are no samples\n", file, count, topic);
  for (const auto& [topic, why] : contents.other)
    fmt::print(stderr, "c3rt: {}: {} is left out: {}\n", file, topic, why);
}

std::string text_of(const Contents& contents, const char* metadata, const char* key) {
  const auto texts = contents.metadata.find(metadata);
  if (texts == contents.metadata.end()) return "";
  const auto value = texts->second.find(key);
  return value == texts->second.end() ? "" : value->second;
}

std::vector<std::string> overrides_of(const Contents& contents) {
  const auto list =
      nlohmann::json::parse(text_of(contents, kRunMetadata, "overrides"), nullptr, false);
  const bool texts = list.is_array() && std::all_of(list.begin(), list.end(), [](const auto& item) {
                       return item.is_string();
                     });
  return texts ? list.get<std::vector<std::string>>() : std::vector<std::string>{};
}

std::uint64_t seed_of(const Contents& contents) {
  const std::string text = text_of(contents, kRunMetadata, "seed");
  const bool number =
      !text.empty() && text.size() < 20 &&
      std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  return number ? std::stoull(text) : 1;
}

config::Scenario scenario_of(const Contents& contents, const std::string& file,
                             const std::string& scenario,
                             const std::vector<std::string>& overrides) {
  if (!scenario.empty()) return config::load_scenario(scenario_path(scenario).string(), overrides);
  const auto text = contents.attachments.find(kScenarioAttachment);
  if (text == contents.attachments.end()) {
    throw UsageError(file +
                     " does not tell its scenario (no attachment scenario.yaml): name it with "
                     "--scenario");
  }
  // what it names beside it (an object's model) is found from where it was
  const std::string where = text_of(contents, kRunMetadata, "file");
  return config::read_scenario(
      config::Document::parse(text->second, where.empty() ? file : where, overrides));
}

}  // namespace c3rt::cli
