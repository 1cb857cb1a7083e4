// The command as a person meets it, with stubs in the place of the four processes.
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/place.hpp"

using namespace c3rt::cli;
using c3rt::support::Outcome;
using Catch::Contains;

namespace {

constexpr int kDomain = 94;

nlohmann::json findings_of(const Outcome& outcome) {
  return nlohmann::json::parse(outcome.output.substr(outcome.output.find('{')))["findings"];
}

/// What it says about one thing; null where it says nothing.
nlohmann::json about(const nlohmann::json& findings, const std::string& name) {
  for (const auto& finding : findings) {
    if (finding["about"] == name) return finding;
  }
  return nullptr;
}

}  // namespace

TEST_CASE(
    "doctor: of an instance each process, its pid and user are told; of no instance how to start "
    "one") {
  const Place place(kDomain);
  const auto none = findings_of(place.c3rt("doctor --json" + place.on_domain()));
  CHECK(about(none, "instance")["verdict"] == "warning");
  CHECK(about(none, "plant").is_null());

  for (const char* name : {"plant", "impedance", "planner", "vision"})
    place.process(name, std::string("exec -a c3rt-") + name + " '" C3RT_STUB_PROCESS "' \"$@\"");
  REQUIRE(place.c3rt("up circle_slow" + place.start_options()).status == 0);
  const auto all = findings_of(place.c3rt("doctor --json" + place.on_domain()));
  for (const char* name : {"plant", "impedance", "planner", "vision"}) {
    const auto finding = about(all, name);
    REQUIRE_FALSE(finding.is_null());
    CHECK(finding["verdict"] == "ok");
    CHECK_THAT(finding["said"].get<std::string>(),
               Contains("pid " + std::to_string(place.pid(name)) + ", user "));
  }
  CHECK(about(all, "second writers").is_null());
  CHECK(about(all, "peers")["verdict"] == "ok");
  CHECK(about(all, "interface lo")["verdict"] == "ok");
  CHECK(place.c3rt("down" + place.on_domain()).status == 0);
}

TEST_CASE(
    "doctor: a profile that is not there, or that DDS refuses, is a problem with its reason") {
  const Place place(kDomain);
  const Outcome unknown = place.c3rt("doctor --profile no_such_profile" + place.on_domain());
  CHECK(unknown.status == 1);
  CHECK_THAT(unknown.output, Contains("unknown DDS profile \"no_such_profile\"; known: "));
  const auto file = place.path() / "broken.xml";
  std::ofstream(file) << "<CycloneDDS><Domain><General><Interfaces><NetworkInterface "
                         "name='no_such_interface'/></Interfaces></General></Domain></CycloneDDS>";
  const Outcome broken = place.c3rt("doctor --profile '" + file.string() + "'" + place.on_domain());
  CHECK(broken.status == 1);
  CHECK_THAT(broken.output, Contains("no_such_interface does not exist; this host has"));
}
