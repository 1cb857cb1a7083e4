// c3rt::client beside real processes, in lockstep: what docs/clients.md promises of C++.
#include <algorithm>
#include <cmath>
#include <cstdio>
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

/// A program of examples/; its words are in a file.
class Example {
 public:
  Example(const std::string& clock, const cli::Folder& folder,
          std::vector<std::string> program = {C3RT_CPP_PLANNER})
      : words_(folder.path() / "example.log"),
        process_(with(std::move(program), {"--clock", clock, "--domain", kDomain}),
                 words_.string()) {}
  /// Exit status and words.
  std::pair<int, std::string> end() {
    const int status = process_.wait();
    return {status, text_of(words_)};
  }
  void signal(int number) const { process_.signal(number); }

 private:
  static std::vector<std::string> with(std::vector<std::string> words,
                                       const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  std::filesystem::path words_;
  ChildProcess process_;
};

support::Outcome c3rt_command(const std::string& arguments, const cli::Folder& folder) {
  return support::outcome_of("XDG_RUNTIME_DIR='" + folder.path().string() + "' '" +
                             test::program("c3rt") + "' " + arguments + " --domain " + kDomain);
}

/// circle_slow in lockstep with an estimator of one's own. @return its report
nlohmann::json run_without_vision(double duration, const std::filesystem::path& out,
                                  const cli::Folder& folder) {
  const support::Outcome run = c3rt_command(
      "run circle_slow --without vision --clock lockstep --no-pictures --duration " +
          std::to_string(duration) + " --set 'criteria=[]' --out '" + out.string() + "'",
      folder);
  INFO(run.output);
  REQUIRE(run.status == 0);
  return nlohmann::json::parse(text_of(out / "report.json"));
}

/// A ball that a camera straight above sees, as examples/cpp_estimator/camera.cpp has it.
void draw(const std::filesystem::path& file, double x, double y) {
  std::ofstream stream(file, std::ios::binary);
  stream << "P5\n400 600\n255\n";
  for (int row = 0; row < 600; ++row) {
    for (int column = 0; column < 400; ++column) {
      const double p_x = 0.35 + 0.001 * (column + 0.5), p_y = 0.3 - 0.001 * (row + 0.5);
      stream.put(static_cast<char>(std::hypot(p_x - x, p_y - y) < 0.0315 ? 220 : 32));
    }
  }
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

/// These columns of a table, row after row.
std::vector<std::vector<double>> columns(const std::filesystem::path& file,
                                         const std::vector<std::string>& names) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> header = cells_of(line);
  std::vector<std::vector<double>> rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = cells_of(line);
    std::vector<double>& row = rows.emplace_back();
    for (const std::string& name : names) {
      const auto at = std::find(header.begin(), header.end(), name);
      REQUIRE(at != header.end());
      row.push_back(std::stod(cells.at(static_cast<std::size_t>(at - header.begin()))));
    }
  }
  return rows;
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

    // of the robot itself, by the same client and by a person's words
    c3rt_v2_ContactThresholds soft{};
    std::fill(std::begin(soft.collision_torque_nm), std::end(soft.collision_torque_nm), 40.0);
    std::fill(std::begin(soft.collision_force_E_n), std::end(soft.collision_force_E_n), 30.0);
    std::fill(std::begin(soft.collision_torque_E_nm), std::end(soft.collision_torque_E_nm), 30.0);
    CHECK_THROWS_WITH(robot.thresholds(soft, soft, patience),
                      "plant: refused: expected a robot that nothing moves (c3rt stop), got one "
                      "that follows commands");
    const std::string soften = "robot thresholds --collision-torque 40 --collision-force 30";
    CHECK(c3rt_command(soften, folder).status == 1);
    CHECK(robot.user_stop(true, patience).ok);
    CHECK_THROWS_AS(robot.recover(patience), client::Refused);
    CHECK_THROWS_AS(robot.guide(63, true, patience), client::Refused);
    CHECK(robot.user_stop(false, patience).ok);
    CHECK(robot.thresholds(soft, soft, patience).text == "thresholds set");
    const support::Outcome set = c3rt_command(soften, folder);
    INFO(set.output);
    CHECK(set.status == 0);
    CHECK_THAT(set.output, Catch::Contains("plant: thresholds set"));
    CHECK(c3rt_command("robot guide --axes x,y", folder).status == 0);
    CHECK(robot.newest<wire::RobotContact>(patience).guided);
    CHECK(robot.release(patience).ok);
    CHECK(robot.stop(patience).size() == 3);
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

TEST_CASE(
    "cpp client: an estimator a millimetre wrong takes vision's place, twice with the same bits") {
  const cli::Folder folder;
  std::string hash;
  for (const char* turn : {"first", "second"}) {
    Example estimator("lockstep", folder, {C3RT_CPP_ESTIMATOR});
    const nlohmann::json report = run_without_vision(3.0, folder.path() / turn, folder);
    CHECK(estimator.end() == std::pair<int, std::string>{0, ""});
    const auto& client = report.at("clients").at(0);
    CHECK(client.at("process") == "vision");
    CHECK(client.at("problems").empty());
    CHECK(client.at("rate_hz").get<double>() == Approx(80.0).epsilon(0.01));
    const auto& error = report.at("vision").at("error_m");
    CHECK(error.at("p50").get<double>() > 3e-4);
    CHECK(error.at("p50").get<double>() < 3e-3);
    CHECK(error.at("max").get<double>() < 6e-3);
    if (hash.empty()) hash = report.at("log_hash");
    CHECK(report.at("log_hash") == hash);
  }
}

TEST_CASE("cpp client: a motion generator takes impedance's place and turns a joint as it says") {
  const cli::Folder folder;
  Example mover("lockstep", folder, {C3RT_CPP_MOVER});  // in lockstep the others wait for it
  const support::Outcome up =
      c3rt_command("up circle_slow --without impedance --clock lockstep --out '" +
                       folder.path().string() + "/out'",
                   folder);
  INFO(up.output);
  REQUIRE(up.status == 0);
  {
    const std::filesystem::path words = folder.path() / "example.log";
    for (int i = 0; i < 1200 && text_of(words).empty(); ++i) usleep(100'000);
    CHECK_THAT(text_of(words),
               Catch::StartsWith("turned by 0.3") || Catch::StartsWith("turned by 0.299"));
    client::Client robot(test::test_domain());
    const auto state = robot.newest<wire::RobotState>(120.0);
    CHECK(state.q_rad[6] == Approx(0.3).margin(2e-3));  // the arm starts with 0 there
    CHECK(state.mode == c3rt_v2_ROBOT_IDLE);
    CHECK(state.errors == 0);
    mover.signal(SIGTERM);
    CHECK(mover.end().first == 0);
  }
  CHECK(c3rt_command("down", folder).status == 0);
}

TEST_CASE("cpp client: a camera of one's own finds the ball of each file") {
  const cli::Folder folder;
  const std::filesystem::path files = folder.path() / "files";
  std::filesystem::create_directories(files);
  constexpr int kFiles = 25;
  for (int i = 0; i < kFiles; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "%03d.pgm", i);
    draw(files / name, 0.55 + 0.001 * i, 0.05);
  }
  Example camera("lockstep", folder, {C3RT_CPP_CAMERA, files.string()});
  const nlohmann::json report = run_without_vision(0.6, folder.path() / "out", folder);
  CHECK(camera.end() == std::pair<int, std::string>{0, ""});
  const std::filesystem::path recorded = folder.path() / "out" / "run.mcap";
  const support::Outcome tables =
      support::outcome_of("'" + test::program("c3rt") + "' export '" + recorded.string() +
                          "' --topics object/estimate --out '" + folder.path().string() + "'");
  INFO(tables.output);
  REQUIRE(tables.status == 0);
  const std::vector<std::vector<double>> seen =
      columns(folder.path() / "object_estimate.csv", {"p_WB_m_0", "p_WB_m_1", "v_WB_m_per_s_0"});
  REQUIRE(seen.size() >= kFiles);
  double v = 0.0;
  for (int i = 0; i < kFiles; ++i) {
    const auto& row = seen[static_cast<std::size_t>(i)];
    CHECK(row[0] == Approx(0.55 + 0.001 * i).margin(2e-4));
    CHECK(row[1] == Approx(0.05).margin(2e-4));
    if (i > 0) v += row[2] / (kFiles - 1);
  }
  CHECK(v == Approx(0.05).epsilon(0.05));
}
