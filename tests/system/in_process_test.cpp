// c3rt run --in-process: the samples of four processes in lockstep, to the last bit, and the same
// verdict.
#include <fstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/child_process.hpp"

using namespace c3rt;
using nlohmann::json;

namespace {

struct Run {
  int status;
  json report;
};

Run run(const std::string& how, const std::vector<std::string>& arguments) {
  const std::string directory = std::string(C3RT_BINARY_DIRECTORY) + "/in_process_" + how;
  std::vector<std::string> command{test::program("c3rt"), "run"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  command.insert(command.end(), {"--no-pictures", "--out", directory});
  if (how == "lockstep") {
    command.insert(command.end(), {"--clock", "lockstep", "--domain", "any"});
  } else {
    command.push_back("--in-process");
  }
  test::ChildProcess child(command, directory + ".log");
  Run result{child.wait(), {}};
  std::ifstream file(directory + "/report.json");
  if (file) file >> result.report;
  return result;
}

/// What the machine measured, which no two runs have in common.
json without_times(json report) {
  report.at("plant").erase("real_time_factor");
  report.at("planner").erase("solve_time_s");
  report.erase("impedance");
  return report;
}

}  // namespace

TEST_CASE("in process: every sample is as in lockstep, whatever is planned with and seen") {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"circle_slow", "--duration", "9"},
                                             {"path_rectangle", "--duration", "5", "--seed", "3"},
                                             {"three_balls_plus", "--duration", "5", "--seed", "2"},
                                             {"circle_vision", "--duration", "2"}}) {
    CAPTURE(arguments.front());
    const Run apart = run("lockstep", arguments);
    const Run together = run("here", arguments);
    REQUIRE(apart.report.is_object());
    REQUIRE(together.report.is_object());
    CHECK(together.status == apart.status);
    CHECK(together.report.at("log_hash") == apart.report.at("log_hash"));
    CHECK(without_times(together.report) == without_times(apart.report));
  }
}

TEST_CASE("in process: another seed gives other samples, the same seed the same again") {
  const std::vector<std::string> arguments{"circle_slow", "--duration", "3", "--seed"};
  const auto hash = [&](const std::string& seed) {
    std::vector<std::string> all = arguments;
    all.push_back(seed);
    return run("here", all).report.at("log_hash").get<std::string>();
  };
  const std::string first = hash("5");
  CHECK(hash("5") == first);
  CHECK(hash("6") != first);
}

TEST_CASE("in process: criteria decide the exit status, and it tells what its nodes say") {
  const Run circle =
      run("here", {"circle_slow", "--set", "task.loops=1", "--set", "criteria.0.min=1"});
  CHECK(circle.status == 0);
  CHECK(circle.report.at("result") == "passed");
  CHECK(circle.report.at("clock") == "lockstep");
  CHECK(circle.report.at("impedance").at("missed_cycles") == 0);
  CHECK(circle.report.at("impedance").at("compute_s").at("p50").get<double>() > 0.0);
  std::ifstream log(std::string(C3RT_BINARY_DIRECTORY) + "/in_process_here/logs/in-process.log");
  const std::string said{std::istreambuf_iterator<char>(log), std::istreambuf_iterator<char>()};
  CHECK_THAT(said, Catch::Contains("plant: mode follows commands") &&
                       Catch::Contains("vision: object=0 found"));

  CHECK(run("here", {"circle_slow", "--duration", "2"}).status == 1);
}

TEST_CASE("in process: what slides and what rolls come to their goals, and both stay there") {
  const Run both = run("here", {"cone_and_ball", "--seed", "106"});
  CHECK(both.status == 0);
  CHECK(both.report.at("task").at("goals_reached") == 2);
  CHECK(both.report.at("task").at("end_position_error_m").get<double>() < 0.012);
  for (const json& object : both.report.at("objects"))
    CHECK(object.at("max_error_m").get<double>() > 0.02);
}

TEST_CASE("in process: what needs DDS or the machine's clock is a usage error") {
  for (const char* option : {"--domain=3", "--dds=lan", "--clock=realtime"}) {
    CAPTURE(option);
    CHECK(run("here", {"circle_slow", option}).status == 2);
  }
  CHECK(run("here", {"cart_pole"}).status == 2);
}
