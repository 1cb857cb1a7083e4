#include "cli/chaos/kinds.hpp"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

#include "cli/chaos/stranger.hpp"
#include "cli/paths.hpp"

namespace c3rt::cli::chaos {
namespace {

constexpr unsigned kBoth = kRealtime | kSimulated;
constexpr c3rt_v2_FaultKind kNothing = c3rt_v2_FAULT_NONE;

std::vector<std::string_view> edge_names() {
  std::vector<std::string_view> names;
  for (const Edge& edge : edges()) names.push_back(edge.name);
  return names;
}

bool is_offered(const Kind& kind, const Offer& offer) {
  const bool needs_cameras = kind.injected == c3rt_v2_FAULT_FREEZE_CAMERA;
  return (kind.where & offer.where) != 0 && (!needs_cameras || offer.cameras > 0) &&
         (kind.act != Act::kFillDisk || offer.small_disk);
}

template <typename Names>
std::string listed(const Names& names) {
  std::string text;
  for (const std::string_view name : names) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}

Choice chosen(const std::string& word, const Offer& offer) {
  const std::size_t colon = word.find(':');
  const std::string name = word.substr(0, colon);
  const auto found = std::find_if(kinds().begin(), kinds().end(),
                                  [&name](const Kind& kind) { return kind.name == name; });
  if (found == kinds().end() || !is_offered(*found, offer)) {
    std::vector<std::string_view> names;
    for (const Kind& kind : kinds()) {
      if (is_offered(kind, offer)) names.push_back(kind.name);
    }
    const char* why =
        found == kinds().end() ? "there is no such kind"
        : (found->where & offer.where) == 0
            ? (offer.where == kRealtime ? "it needs --in-process" : "it needs real processes")
        : found->act == Act::kFillDisk
            ? "it needs --out on a file system of its own, of at most 64 MiB, which it fills"
            : "the scenario has no cameras";
    throw UsageError(fmt::format("--faults {}: {}; expected {}", word, why, listed(names)));
  }
  if (colon == std::string::npos) return {&*found, found->targets};
  const std::string target = word.substr(colon + 1);
  const auto at = std::find(found->targets.begin(), found->targets.end(), target);
  if (at == found->targets.end()) {
    throw UsageError(
        fmt::format("--faults {}: expected a target of {}", word, listed(found->targets)));
  }
  return {&*found, {*at}};
}

}  // namespace

const std::vector<Edge>& edges() {
  static const std::vector<Edge> all{
      {"state-to-impedance", &wire::topic<wire::RobotState>(), c3rt_v2_PROCESS_IMPEDANCE},
      {"state-to-planner", &wire::topic<wire::RobotState>(), c3rt_v2_PROCESS_PLANNER},
      {"command-to-plant", &wire::topic<wire::RobotCommand>(), c3rt_v2_PROCESS_PLANT},
      {"plan-to-impedance", &wire::topic<wire::Plan>(), c3rt_v2_PROCESS_IMPEDANCE},
      {"estimate-to-planner", &wire::topic<wire::ObjectEstimate>(), c3rt_v2_PROCESS_PLANNER},
      {"scene-to-vision", &wire::topic<wire::Scene>(), c3rt_v2_PROCESS_VISION}};
  return all;
}

const std::vector<Kind>& kinds() {
  static const std::vector<std::string_view> kFour{"plant", "impedance", "planner", "vision"};
  static const std::vector<double> kShort{0.02, 0.2, 2.0}, kNone;
  // clang-format off
  static const std::vector<Kind> all{
      {"kill", Act::kKill, kNothing, kBoth, kFour, kNone, 0, 0, "kill -9, and it is started again (simulated: not the plant)"},
      {"kill-service", Act::kKillService, kNothing, kRealtime, {"supervisor"}, kNone, 0, 0, "kill -9 of the supervisor of c3rt up; only where it is named", true},
      {"stop", Act::kStop, kNothing, kBoth, kFour, {0.1, 1.0, 10.0}, 0, 0, "SIGSTOP, later SIGCONT"},
      {"stall", Act::kInject, c3rt_v2_FAULT_STALL, kBoth, kFour, {0.01, 0.1, 1.0}, 0, 0, "the process takes and sends nothing"},
      {"nan", Act::kInject, c3rt_v2_FAULT_NAN, kBoth, kFour, {0.01, 0.1, 1.0}, 0, 0, "the process writes NaN"},
      {"drop-commands", Act::kInject, c3rt_v2_FAULT_DROP_COMMANDS, kBoth, {"plant"}, {0.005, 0.015, 0.1, 0.5}, 0, 0, "the plant ignores commands"},
      {"push", Act::kInject, c3rt_v2_FAULT_PUSH_OBJECT, kBoth, {"plant"}, kNone, 0.02, 0.1, "an object is pushed, by its mass and so many m/s"},
      {"freeze-camera", Act::kInject, c3rt_v2_FAULT_FREEZE_CAMERA, kBoth, {"vision"}, {0.2, 1.0, 5.0}, 0, 0, "one camera delivers nothing"},
      {"occlude", Act::kInject, c3rt_v2_FAULT_LOSE_OBJECT, kBoth, {"vision"}, {0.1, 0.5, 2.0}, 0, 0, "no camera sees an object"},
      {"delay", Act::kDelay, kNothing, kSimulated, edge_names(), kShort, 0.002, 0.1, "samples come later by so many s"},
      {"drop", Act::kDrop, kNothing, kSimulated, edge_names(), kShort, 0.05, 1.0, "a share of the samples is lost"},
      {"duplicate", Act::kDuplicate, kNothing, kSimulated, edge_names(), kShort, 0.05, 1.0, "a share of the samples comes twice"},
      {"reorder", Act::kReorder, kNothing, kSimulated, edge_names(), kShort, 0.002, 0.05, "each sample comes later by up to so many s"},
      {"spoil", Act::kSpoil, kNothing, kSimulated, edge_names(), kShort, 0.05, 1.0, "a share of the samples has a NaN"},
      {"clock-jump", Act::kShiftClock, kNothing, kSimulated, edge_names(), kShort, 0.002, 0.9, "stamps jump by so many s, there and back"},
      {"wrong-object", Act::kShiftObject, kNothing, kSimulated, {"estimate-to-planner"}, kShort, 0.002, 0.03, "the object is told so many m away"},
      {"second-writer", Act::kDouble, kNothing, kRealtime, doubled_topics(), {0.2, 2.0}, 20.0, 2000.0, "somebody else writes a topic, too, what misleads"},
      {"flood", Act::kFlood, kNothing, kRealtime, flooded_topics(), {0.2, 2.0}, 100.0, 10000.0, "somebody asks so many times a second what nobody grants"},
      {"full-disk", Act::kFillDisk, kNothing, kRealtime, {"results"}, {0.5, 5.0}, 0, 0, "the file system of --out is full; only of one of at most 64 MiB"}};
  // clang-format on
  return all;
}

std::vector<Choice> choose(const std::string& list, const Offer& offer) {
  std::vector<Choice> choices;
  if (list.empty()) {
    for (const Kind& kind : kinds()) {
      if (is_offered(kind, offer) && !kind.if_named) choices.push_back({&kind, kind.targets});
    }
  }
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) choices.push_back(chosen(word, offer));
  // a simulated plant is time itself
  for (Choice& choice : choices) {
    if (choice.kind->act != Act::kKill || offer.where != kSimulated) continue;
    auto& targets = choice.targets;
    targets.erase(std::remove(targets.begin(), targets.end(), "plant"), targets.end());
    if (targets.empty()) throw UsageError("--faults kill:plant: it needs real processes");
  }
  if (choices.empty()) throw UsageError("--faults: expected at least one kind");
  return choices;
}

std::string kinds_text() {
  std::string text = "Kinds of faults (KIND or KIND:TARGET):\n";
  for (const Kind& kind : kinds()) {
    const char* where = kind.where == kSimulated  ? " [--in-process]"
                        : kind.where == kRealtime ? " [real time]"
                                                  : "";
    text += fmt::format("  {:<14} {}{}\n", kind.name, kind.says, where);
  }
  return text + "Targets are processes, edges (" + listed(edge_names()) + "), or topics (" +
         listed(doubled_topics()) + "; " + listed(flooded_topics()) + ").\n";
}

wire::Process process_of(std::string_view name) {
  for (int i = 0; i < wire::kProcessCount; ++i) {
    const auto process = static_cast<wire::Process>(i);
    if (name == wire::process_name(process)) return process;
  }
  throw std::invalid_argument("no process " + std::string(name));
}

}  // namespace c3rt::cli::chaos
