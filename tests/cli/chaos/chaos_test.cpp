// c3rt chaos, as a person calls it, in simulated time.
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/long_run.hpp"

using namespace c3rt;
using nlohmann::json;

namespace {

struct Shaken : cli::LongRun {
  std::string faults;
};

Shaken chaos(const std::vector<std::string>& arguments) {
  const cli::Folder folder;
  const cli::LongRun run = cli::long_run("chaos", arguments, folder);
  return {run, cli::read_text(folder.path() / "out" / "faults.csv")};
}

}  // namespace

TEST_CASE("chaos: the same seed gives the same bits and the same faults, and all is well") {
  const std::vector<std::string> arguments{"circle_service", "--in-process", "--duration", "40s",
                                           "--rate",         "15",           "--seed",     "2"};
  const Shaken one = chaos(arguments), two = chaos(arguments);
  CAPTURE(one.said);
  REQUIRE(one.report.is_object());
  CHECK(one.status == 0);
  CHECK(one.report.at("violations").at("count") == 0);
  CHECK(one.report.at("faults").get<int>() >= 4);
  CHECK(one.report.at("log_hashes") == two.report.at("log_hashes"));
  CHECK(one.faults == two.faults);
}

TEST_CASE("chaos: what does not go on is a violation, and is shown again by its command") {
  // who recovers a robot by hand is not there
  const Shaken shaken = chaos({"circle_service", "--in-process", "--duration", "45s", "--faults",
                               "stall:impedance,stop:impedance", "--rate", "20", "--set",
                               "service.recovery=by_person"});
  CAPTURE(shaken.said);
  REQUIRE(shaken.report.is_object());
  CHECK(shaken.status == 1);
  CHECK(shaken.report.at("result") == "violated");
  CHECK(shaken.report.at("violations").at("by_name").at("not_recovered") == 1);
  const std::string again = shaken.report.at("reproduce");
  CHECK_THAT(again, Catch::Contains("--seed 1") && Catch::Contains("--in-process") &&
                        Catch::Contains("--faults stall:impedance,stop:impedance") &&
                        Catch::Contains("--set service.recovery=by_person"));
  CHECK(shaken.said.find(again) != std::string::npos);
}

TEST_CASE("chaos: Ctrl-C ends it with the report of what was done") {
  const cli::Folder folder;
  const auto [status, report, said] =
      cli::long_run("chaos", {"circle_service", "--in-process", "--duration", "24h"}, folder, true);
  CHECK(status == 1);
  REQUIRE(report.is_object());
  CHECK(report.at("result") == "interrupted");
}

TEST_CASE("chaos: what cannot be done is a usage error") {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"circle_service", "--in-process", "--faults", "earthquake"},
           {"circle_service", "--in-process", "--faults", "freeze-camera"},
           {"circle_service", "--faults", "delay"},
           {"circle_service", "--clock", "lockstep"},
           {"circle_service", "--rate", "0"},
           {"circle_service", "--duration", "soon"},
           {"no_such_scenario"}}) {
    CAPTURE(arguments);
    CHECK(chaos(arguments).status == 2);
  }
}
