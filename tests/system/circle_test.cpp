// c3rt run with all processes in lockstep: the ball goes round, twice the same, and nothing is left
// behind.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <thread>
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

Run run(const std::string& name, const std::vector<std::string>& arguments) {
  const std::string directory = std::string(C3RT_BINARY_DIRECTORY) + "/system_" + name;
  std::vector<std::string> command{test::program("c3rt"), "run"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  command.insert(command.end(), {"--clock", "lockstep", "--domain", "any", "--out", directory});
  test::ChildProcess child(command, directory + ".log");
  Run result{child.wait(), {}};
  std::ifstream file(directory + "/report.json");
  if (file) file >> result.report;
  return result;
}

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Processes that `parent` started, by name.
std::map<std::string, pid_t> children_of(pid_t parent) {
  std::map<std::string, pid_t> children;
  const std::string id = std::to_string(parent);
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + id + "/task")) {
    std::istringstream pids(read_file(thread.path() / "children"));
    for (pid_t pid = 0; pids >> pid;) {
      std::string name = read_file("/proc/" + std::to_string(pid) + "/comm");
      if (!name.empty()) name.pop_back();
      children[name] = pid;
    }
  }
  return children;
}

/// Keeps every core busy while it lives.
class Load {
 public:
  Load() {
    for (unsigned i = 0; i < std::max(2u, std::thread::hardware_concurrency()); ++i)
      threads_.emplace_back([this] {
        while (!stop_) {
        }
      });
  }
  ~Load() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace

TEST_CASE("system: the four processes roll the ball round the circle inside the 2 cm band") {
  const Run circle =
      run("circle_slow", {"circle_slow", "--set", "task.loops=1", "--set", "criteria.0.min=1"});
  CHECK(circle.status == 0);
  const json& report = circle.report;
  CHECK(report.at("loops_completed") == 1);
  CHECK(report.at("loop_times_s").at(0).get<double>() < 25.0);
  CHECK(report.at("objects").at(0).at("in_band_2cm").get<double>() == 1.0);
  CHECK(report.at("end_effector").at("tracking_error_m").at("p95").get<double>() < 0.003);
  CHECK(report.at("planner").at("fallbacks") == 0);
  CHECK(report.at("plant").at("reflexes").empty());
}

TEST_CASE("system: with three cameras the estimate stays within 1 mm while the ball rolls") {
  const Run vision = run("circle_vision", {"circle_vision", "--duration", "10"});
  const json& error = vision.report.at("vision").at("error_m");
  CHECK(error.at("p95").get<double>() < 0.001);
  CHECK(vision.report.at("vision").at("dropped_frames") == 0);
  // a tenth of a circle at least: the ball did roll
  CHECK(vision.report.at("objects").at(0).at("in_band_2cm").get<double>() > 0.0);
}

TEST_CASE("system: the same scenario and seed give the same log, also while the machine is busy") {
  const std::vector<std::string> arguments{"circle_fast", "--duration", "4", "--seed", "5"};
  const Run idle = run("same_idle", arguments);
  const Run busy = [&] {
    const Load load;
    return run("same_busy", arguments);
  }();
  const Run other = run("same_other", {"circle_fast", "--duration", "4", "--seed", "6"});
  const std::string hash = idle.report.at("log_hash");
  CHECK_FALSE(hash.empty());
  CHECK(busy.report.at("log_hash") == hash);
  CHECK(other.report.at("log_hash") != hash);
}

TEST_CASE("system: a run that misses a criterion ends with status 1, and says which") {
  const Run short_run = run("criterion", {"circle_slow", "--duration", "2"});
  CHECK(short_run.status == 1);
  bool named = false;
  for (const json& criterion : short_run.report.at("criteria"))
    named = named || (criterion.at("name") == "loops_completed" && criterion.at("met") == false);
  CHECK(named);
}

TEST_CASE("system: a robot that stopped and that nobody recovers ends the run, by name") {
  // stiff and without damping the arm swings up until it is too fast for the robot
  const Run stopped =
      run("reflex", {"circle_slow", "--duration", "20", "--set", "planner.approach.leash_m=1",
                     "--set", "impedance.limits.reference_speed_m_per_s=2", "--set",
                     "impedance.limits.dq_max_rad_per_s=[10, 10, 10, 10, 10, 10, 10]", "--set",
                     "impedance.gains.stiffness_translation_per_s2=5000", "--set",
                     "impedance.gains.damping_translation_per_s=0"});
  CHECK(stopped.status == 1);
  const std::string result = stopped.report.at("result");
  CHECK_THAT(result, Catch::Contains("the robot stopped: joint_velocity_violation"));
  CHECK(stopped.report.at("duration_s").get<double>() < 15.0);
}

TEST_CASE(
    "system: a process that is killed is named with its log's end, and nothing is left behind") {
  const std::string directory = std::string(C3RT_BINARY_DIRECTORY) + "/system_killed";
  test::ChildProcess run({test::program("c3rt"), "run", "circle_slow", "--clock", "lockstep",
                          "--domain", "any", "--out", directory},
                         directory + ".log");
  std::map<std::string, pid_t> children;
  // between fork and exec a child still has its parent's name
  const auto begun = [&] { return children.size() == 4 && children.count("c3rt") == 0; };
  for (int i = 0; i < 600 && !begun(); ++i) {
    usleep(50'000);
    children = children_of(run.pid());
  }
  REQUIRE(begun());
  // until it has said something that the end of its log can show
  for (int i = 0;
       i < 600 && read_file(directory + "/logs/vision.log").find("found") == std::string::npos; ++i)
    usleep(50'000);
  REQUIRE(kill(children.at("c3rt-vision"), SIGKILL) == 0);
  CHECK(run.wait() == 3);
  const std::string said = read_file(directory + ".log");
  CHECK_THAT(said,
             Catch::Contains("vision was killed by signal 9") && Catch::Contains("object=0 found"));
  for (const auto& [name, pid] : children) {
    CAPTURE(name);
    CHECK(kill(pid, 0) != 0);
  }
}

TEST_CASE("system: a box goes through plant, vision and planner to its goal pose") {
  const Run pushed = run("push_box", {"push_box", "--seed", "3"});
  REQUIRE(pushed.status == 0);
  const json& task = pushed.report.at("task");
  CHECK(task.at("goals_reached") == 1);
  CHECK(task.at("goal_time_s").get<double>() < 40.0);
  CHECK(task.at("end_position_error_m").get<double>() < 0.01);
  CHECK(task.at("end_angle_error_rad").get<double>() < 0.1);
  // it began centimetres away, and turned by 2.5 rad
  CHECK(pushed.report.at("objects").at(0).at("max_error_m").get<double>() > 0.03);
}

TEST_CASE("system: goals drawn from the seed are the same ones for planner and report") {
  const auto some = [](const std::string& seed) {
    return run("endurance_t_" + seed,
               {"endurance_t", "--seed", seed, "--set", "task.random_goals=3", "--set",
                "criteria.0.min=3", "--duration", "60"});
  };
  for (const std::string seed : {"2", "3"}) {
    CAPTURE(seed);
    const Run done = some(seed);
    CHECK(done.status == 0);
    const json& task = done.report.at("task");
    CHECK(task.at("goals_reached") == 3);
    CHECK(task.at("goals_missed") == 0);
    // one that was reached took longer than it has to stay
    CHECK(task.at("goal_time_median_s").get<double>() > 1.0);
    CHECK(task.at("goal_time_longest_s").get<double>() < task.at("goal_time_s").get<double>());
  }
}
