#include "cli/chaos/schedule.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "cli/chaos/lines.hpp"
#include "cli/paths.hpp"

using namespace c3rt::cli;
using namespace c3rt::cli::chaos;

namespace {

constexpr Offer kInOneProcess{kSimulated, 3}, kOfProcesses{kRealtime, 3};

std::vector<Fault> drawn(const std::vector<Choice>& choices, double rate, std::uint64_t seed,
                         int count) {
  Schedule schedule(choices, rate, seed);
  std::vector<Fault> faults;
  for (int i = 0; i < count; ++i) faults.push_back(schedule.next());
  return faults;
}

std::string words(const std::vector<Fault>& faults) {
  std::string all;
  for (const Fault& fault : faults)
    all += describe(fault) + " at " + std::to_string(fault.begin) + " " +
           std::to_string(fault.seed) + "\n";
  return all;
}

}  // namespace

TEST_CASE("chaos: the same seed draws the same faults at the same times, another one others") {
  const auto choices = choose("", kInOneProcess);
  CHECK(words(drawn(choices, 6.0, 3, 200)) == words(drawn(choices, 6.0, 3, 200)));
  CHECK(words(drawn(choices, 6.0, 3, 200)) != words(drawn(choices, 6.0, 4, 200)));
}

TEST_CASE("chaos: faults follow one another with half to one and a half of the mean gap between") {
  double end = Schedule::kFirst, sum = 0.0;
  const auto faults = drawn(choose("", kInOneProcess), 12.0, 1, 2000);
  for (const Fault& fault : faults) {
    const double gap = fault.begin - end;
    REQUIRE(gap >= 2.5);
    REQUIRE(gap < 7.5);
    sum += gap;
    end = fault.end();
  }
  // 2000 of uniform gaps of variance 25 / 12: the mean is within four deviations
  CHECK(sum / 2000.0 == Approx(5.0).margin(0.13));
}

TEST_CASE("chaos: every kind and target that is offered comes, with its durations and amounts") {
  std::map<std::string, std::set<std::string>> targets;
  std::map<std::string, std::set<double>> durations;
  for (const Fault& fault : drawn(choose("", kInOneProcess), 60.0, 1, 5000)) {
    const std::string name(fault.kind->name);
    targets[name].insert(fault.target);
    durations[name].insert(fault.duration);
    const double amount = std::abs(fault.amount);
    REQUIRE(amount >= fault.kind->least * (1.0 - 1e-12));
    REQUIRE(amount <= fault.kind->most * (1.0 + 1e-12));
  }
  const auto simulated = std::count_if(kinds().begin(), kinds().end(), [](const Kind& kind) {
    return (kind.where & kSimulated) != 0;
  });
  CHECK(targets.size() == static_cast<std::size_t>(simulated));
  CHECK(targets["stop"] == std::set<std::string>{"impedance", "planner", "plant", "vision"});
  CHECK(targets["kill"] == std::set<std::string>{"impedance", "planner", "vision"});
  CHECK(targets["delay"].size() == edges().size());
  CHECK(durations["stop"] == std::set<double>{0.1, 1.0, 10.0});
}

TEST_CASE("chaos: a list names kinds, and of a kind one target") {
  const auto choices = choose("kill:plant,stop", kOfProcesses);
  REQUIRE(choices.size() == 2);
  CHECK(choices[0].kind->name == "kill");
  CHECK(choices[0].targets == std::vector<std::string_view>{"plant"});
  CHECK(choices[1].targets.size() == 4);
}

TEST_CASE("chaos: what is not offered is refused with the reason") {
  struct Case {
    const char* list;
    Offer offer;
    const char* says;
  };
  for (const Case& c :
       {Case{"explode", kInOneProcess, "there is no such kind; expected kill, stop"},
        Case{"delay", kOfProcesses, "it needs --in-process"},
        Case{"flood", kInOneProcess, "it needs real processes"},
        Case{"kill:plant", kInOneProcess, "it needs real processes"},
        Case{"freeze-camera", {kSimulated, 0}, "the scenario has no cameras"},
        Case{"full-disk", kOfProcesses, "--out on a file system of its own, of at most 64 MiB"},
        Case{"kill-service", kInOneProcess, "it needs real processes"},
        Case{"stop:robot", kInOneProcess, "expected a target of plant, impedance"},
        Case{",", kInOneProcess, "there is no such kind"}}) {
    CAPTURE(c.list);
    CHECK_THROWS_WITH(choose(c.list, c.offer), Catch::Contains(c.says));
    CHECK_THROWS_AS(choose(c.list, c.offer), UsageError);
  }
  for (const Choice& choice : choose("", {kRealtime, 0}))
    CHECK(choice.kind->name != "freeze-camera");
}

TEST_CASE(
    "chaos: a disk is filled where it is a small one, the service is killed where it is asked") {
  const auto has = [](const std::vector<Choice>& choices, std::string_view name) {
    return std::any_of(choices.begin(), choices.end(),
                       [name](const Choice& choice) { return choice.kind->name == name; });
  };
  CHECK_FALSE(has(choose("", kOfProcesses), "full-disk"));
  CHECK(has(choose("", {kRealtime, 3, true}), "full-disk"));
  CHECK_FALSE(has(choose("", {kRealtime, 3, true}), "kill-service"));
  CHECK(has(choose("stop,kill-service", kOfProcesses), "kill-service"));
}

TEST_CASE("chaos: every target is a process, an edge or a topic") {
  for (const Kind& kind : kinds()) {
    for (const std::string_view target : kind.targets) {
      CAPTURE(kind.name, target);
      const bool is_topic = c3rt::wire::with_topic(target, [](const auto&) {});
      const bool is_of_service = target == "results" || target == "supervisor";
      if (edge_of(target) == nullptr && !is_topic && !is_of_service)
        CHECK_NOTHROW(process_of(target));
    }
    CHECK(kinds_text().find(kind.name) != std::string::npos);
  }
}
