// c3rt::client beside real processes, in lockstep: what docs/clients.md promises of C++.
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "idl/client/client.hpp"
#include "tests/system/service.hpp"

using namespace c3rt;
using test::ChildProcess;

namespace {

const std::string kDomain = std::to_string(test::test_domain());
const std::string kRoll = C3RT_SOURCE_DIRECTORY "/examples/python_planner/roll.yaml";

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// examples/cpp_planner; its words are in a file.
class Example {
 public:
  Example(const std::string& clock, const cli::Folder& folder)
      : words_(folder.path() / "planner.log"),
        process_({C3RT_CPP_PLANNER, "--clock", clock, "--domain", kDomain}, words_.string()) {}
  /// Exit status and words.
  std::pair<int, std::string> end() {
    const int status = process_.wait();
    return {status, text_of(words_)};
  }
  void signal(int number) const { process_.signal(number); }

 private:
  std::filesystem::path words_;
  ChildProcess process_;
};

support::Outcome c3rt_command(const std::string& arguments, const cli::Folder& folder) {
  return support::outcome_of("XDG_RUNTIME_DIR='" + folder.path().string() + "' '" +
                             test::program("c3rt") + "' " + arguments + " --domain " + kDomain);
}

}  // namespace

TEST_CASE("cpp client: a planner of one's own rolls the ball at 20 Hz, twice with the same bits") {
  const cli::Folder folder;
  std::string hash;
  for (const char* turn : {"first", "second"}) {
    Example planner("lockstep", folder);
    const std::filesystem::path out = folder.path() / turn;
    const support::Outcome run =
        c3rt_command("run '" + kRoll + "' --without planner --clock lockstep --no-pictures " +
                         "--no-logs --out '" + out.string() + "'",
                     folder);
    INFO(run.output);
    REQUIRE(run.status == 0);
    const auto [status, words] = planner.end();
    CHECK(words.empty());
    CHECK(status == 0);
    const auto report = nlohmann::json::parse(text_of(out / "report.json"));
    const auto& client = report.at("clients").at(0);
    CHECK(client.at("process") == "planner");
    CHECK(client.at("problems").empty());
    CHECK(client.at("rate_hz").get<double>() == Approx(20.0).epsilon(0.01));
    if (hash.empty()) hash = report.at("log_hash");
    CHECK(report.at("log_hash") == hash);
  }
}

TEST_CASE("cpp client: beside a service in lockstep it reads, asks, and is refused with reasons") {
  const cli::Folder folder;
  const support::Outcome up = c3rt_command(
      "up circle_slow --clock lockstep --out '" + folder.path().string() + "/out'", folder);
  INFO(up.output);
  REQUIRE(up.status == 0);
  const double patience = 120.0;
  {
    // the page's client
    const std::filesystem::path words = folder.path() / "client.log";
    std::vector<std::string> lines;
    {
      const ChildProcess client({C3RT_CPP_CLIENT, kDomain}, words.string());
      for (int i = 0; i < 1000 && lines.size() < 20; ++i) {
        usleep(100'000);
        std::istringstream said(text_of(words));
        lines.clear();
        for (std::string line; std::getline(said, line);) lines.push_back(line);
      }
    }
    INFO(text_of(words));
    REQUIRE(lines.size() >= 20);
    CHECK_THAT(lines[0], Catch::Contains(" at height 0."));
    CHECK_THAT(lines[1], Catch::Contains("circle"));
    for (std::size_t i = 3; i < 20; ++i) CHECK(std::stoull(lines[i]) > std::stoull(lines[i - 1]));
  }
  {
    client::Client robot(test::test_domain());
    CHECK(robot.newest<wire::Plan>(patience).knot_count == 1);
    CHECK_THAT(robot
                   .target("circle",
                           {{"center_m", {0.55, 0.0}}, {"radius_m", {0.08}}, {"lead_rad", {0.349}}},
                           patience)
                   .text,
               Catch::Contains("circle"));
    CHECK_THROWS_AS(robot.target("circle", {{"center_m", {0.55, 0.0}}}, patience), client::Refused);
    CHECK(robot.stop(patience).size() == 3);
    CHECK(robot.newest<wire::RobotState>(patience).mode != c3rt_v2_ROBOT_MOVE);
    CHECK(robot.recover(patience).size() == 3);

    // beside a planner there is no place for another one, of whatever clock
    for (const char* clock : {"lockstep", "realtime"}) {
      Example planner(clock, folder);
      const auto [status, words] = planner.end();
      CHECK(status == 2);
      CHECK_THAT(words, Catch::Contains("error: "));
    }
  }
  CHECK(c3rt_command("down", folder).status == 0);
}

TEST_CASE("cpp client: Ctrl-C and SIGTERM end a planner that waits, without a word") {
  const cli::Folder folder;
  client::Client robot(test::test_domain());
  for (const auto& [number, clock] : {std::pair{SIGINT, "lockstep"}, {SIGTERM, "realtime"}}) {
    Example planner(clock, folder);
    bool waits = false;
    for (int i = 0; i < 100 && !waits; ++i) {
      const auto status = robot.status(0.3)[c3rt_v2_PROCESS_PLANNER];
      waits = status && status->state == c3rt_v2_SERVICE_RUNNING;
    }
    REQUIRE(waits);
    planner.signal(number);
    CHECK(planner.end() == std::pair<int, std::string>{0, ""});
  }
}
