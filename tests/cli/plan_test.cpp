// c3rt plan: a simulator of somebody else's on the other end of its standard streams.
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "controller/mjcf/object.hpp"
#include "controller/scene/scene.hpp"
#include "tests/cli/place.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/random.hpp"

namespace {

using namespace c3rt;
using Catch::Contains;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Json = nlohmann::json;

const std::string kExample = C3RT_SOURCE_DIRECTORY "/examples/gym_pusht/pusht.yaml";
const std::string kObject = C3RT_SOURCE_DIRECTORY "/examples/gym_pusht/t.xml";

/// c3rt plan as a child that answers line by line.
class Door {
 public:
  explicit Door(const std::string& scenario) {
    std::array<int, 2> to{}, from{};
    if (pipe2(to.data(), O_CLOEXEC) != 0 || pipe2(from.data(), O_CLOEXEC) != 0)
      throw std::runtime_error("no pipes");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, to[0], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, from[1], STDOUT_FILENO);
    std::vector<std::string> words{test::program("c3rt"), "plan", scenario};
    std::vector<char*> argv{words[0].data(), words[1].data(), words[2].data(), nullptr};
    const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(to[0]);
    close(from[1]);
    if (error != 0) throw std::runtime_error("cannot start c3rt plan");
    in_ = fdopen(to[1], "w");
    out_ = fdopen(from[0], "r");
  }
  Door(const Door&) = delete;
  Door& operator=(const Door&) = delete;
  ~Door() {
    if (in_ != nullptr) finish();
  }
  Json ask(const Json& scene) const {
    std::fprintf(in_, "%s\n", scene.dump().c_str());
    std::fflush(in_);
    std::string line;
    for (int c = std::getc(out_); c != EOF && c != '\n'; c = std::getc(out_))
      line += static_cast<char>(c);
    return Json::parse(line);
  }
  /// @return its exit status, once it is told no more
  int finish() {
    std::fclose(in_);
    in_ = nullptr;
    int status = 0;
    waitpid(pid_, &status, 0);
    std::fclose(out_);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  FILE *in_ = nullptr, *out_ = nullptr;
};

Json scene_at(double time, const Vector3d& effector, const Vector3d& body, double yaw) {
  const auto list = [](const Vector3d& v) { return Json{v.x(), v.y(), v.z()}; };
  return {{"time_s", time},
          {"end_effector", {{"position_m", list(effector)}}},
          {"objects", {{{"position_m", list(body)}, {"yaw_rad", yaw}}}}};
}

Vector3d vector(const Json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

/// A plane without friction in which a T moves only as a disc pushes it, as in gym-pusht: of all
/// motions that keep it out of the disc the one with the least energy.
class World {
 public:
  static constexpr double kTip = 0.015, kHeight = 0.0055;
  World(const Vector2d& disc, const Vector2d& at, double yaw)
      : object_(mjcf::read_object(kObject).object) {
    effector_.radius = kTip;
    effector_.p_WE << disc, kHeight;
    body_.shape = object_.shape();
    body_.p_WB << at, kHeight;
    yaw_ = yaw;
    settle();
  }
  /// The disc goes there in a straight line; the T gets out of its way.
  void move(const Vector2d& to) {
    constexpr int kSteps = 20;
    const Vector3d way = (Vector3d(to.x(), to.y(), kHeight) - effector_.p_WE) / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      effector_.p_WE += way;
      settle();
    }
  }
  const Vector3d& disc() const { return effector_.p_WE; }
  const Vector3d& at() const { return body_.p_WB; }
  double yaw() const { return std::remainder(yaw_, 2.0 * M_PI); }
  /// How much of the goal the T covers, of points 1 mm apart.
  double coverage(const Vector2d& goal, double goal_yaw) const {
    scene::Body there = body_;
    there.p_WB << goal, kHeight;
    turn(there, goal_yaw);
    int of_goal = 0, covered = 0;
    for (double x = -0.1; x <= 0.1; x += 1e-3) {
      for (double y = -0.1; y <= 0.1; y += 1e-3) {
        scene::Effector point{{goal.x() + x, goal.y() + y, kHeight}};
        if (scene::gap(point, there).distance > 0.0) continue;
        ++of_goal;
        if (scene::gap(point, body_).distance <= 0.0) ++covered;
      }
    }
    return static_cast<double>(covered) / of_goal;
  }

 private:
  static void turn(scene::Body& body, double yaw) {
    body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  }
  void settle() {
    turn(body_, yaw_);
    for (int i = 0; i < 50; ++i) {
      const scene::Gap gap = scene::gap(effector_, body_);
      if (gap.distance > -1e-7) return;
      const Vector3d arm = effector_.p_WE - kTip * gap.normal - body_.p_WB;
      const double lever = arm.cross(gap.normal).z();
      const double mass = object_.mass, inertia = object_.inertia(2, 2);
      const double impulse = -gap.distance / (1.0 / mass + lever * lever / inertia);
      body_.p_WB.head<2>() -= impulse / mass * gap.normal.head<2>();
      yaw_ -= impulse / inertia * lever;
      turn(body_, yaw_);
    }
  }

  scene::Object object_;
  scene::Effector effector_;
  scene::Body body_;
  double yaw_;
};

/// What gym-pusht draws at its reset, at one millimetre a pixel.
World drawn(unsigned seed) {
  support::Random random(seed);
  const auto both = [&](double low, double high) {
    const double x = random.uniform(low, high), y = random.uniform(low, high);
    return Vector2d(x, y);
  };
  const Vector2d disc = both(-0.206, 0.194), block = both(-0.156, 0.144);
  const double yaw = random.uniform(-M_PI, M_PI);
  const Vector2d middle(0.55, 0.0);
  const Vector2d com = 0.045 * Vector2d(-std::sin(yaw), std::cos(yaw));
  return {middle + disc, middle + block + com, yaw};
}

}  // namespace

TEST_CASE("plan: gym-pusht's T covers its goal to 95 % within 300 steps, wherever both begin") {
  const Vector2d goal(0.5181802, 0.0318198);
  const double goal_yaw = M_PI / 4.0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    World world = drawn(seed);
    Door door(kExample);
    double coverage = 0.0;
    int step = 0;
    while (coverage <= 0.95 && step < 300) {
      ++step;
      const Json plan = door.ask(scene_at(0.1 * step, world.disc(), world.at(), world.yaw()));
      const Vector3d there = vector(plan["position_m"]);
      CHECK(std::abs(there.z() - World::kHeight) < 1e-4);  // it never leaves the plane
      // the field, its border too, but for rounding
      CHECK((there - Vector3d(0.55, 0.0, there.z())).cwiseAbs().maxCoeff() <= 0.256 + 1e-12);
      world.move(there.head<2>());
      coverage = world.coverage(goal, goal_yaw);
    }
    CHECK(coverage > 0.95);
    CHECK(door.finish() == 0);
  }
}

TEST_CASE("plan: the same scenes have the same answers, each with all that a robot needs") {
  const cli::Place place;
  const std::string file = (place.path() / "scenes.jsonl").string();
  std::ofstream stream(file);
  for (int i = 1; i <= 20; ++i)
    stream << scene_at(0.02 * i, {0.4 + 0.002 * i, 0.1, 0.1}, {0.55, 0.0, -0.0045}, 0.3) << "\n";
  stream.close();
  const support::Outcome once = place.c3rt("plan push_t < '" + file + "'"),
                         again = place.c3rt("plan push_t < '" + file + "'");
  CHECK(once.status == 0);
  CHECK(once.output == again.output);
  std::istringstream lines(once.output);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const Json plan = Json::parse(line);
    CHECK(plan["time_s"].get<double>() == Approx(0.02 * (count + 1)));
    CHECK(plan["status"] == "ok");
    CHECK(plan["phase"] == "approach");
    CHECK(plan["says"] == "approach");
    for (const char* key : {"position_m", "velocity_m_per_s", "force_n"})
      CHECK(vector(plan[key]).allFinite());
    CHECK(plan["orientation_wxyz"].size() == 4);
  }
  CHECK(count == 20);
}

TEST_CASE("plan: an orientation may be a quaternion, and an object that is out of reach is named") {
  const cli::Place place;
  Json scene = scene_at(1.0, {0.4, 0.1, 0.1}, {0.55, 0.0, -0.0045}, 0.0);
  scene["objects"][0].erase("yaw_rad");
  scene["objects"][0]["orientation_wxyz"] = {std::cos(0.15), 0.0, 0.0, std::sin(0.15)};
  const Json far = scene_at(1.02, {0.4, 0.1, 0.1}, {1.9, 0.0, -0.0045}, 0.0);
  const std::string file = (place.path() / "scenes.jsonl").string();
  std::ofstream(file) << scene << "\n\n" << far << "\n";
  const support::Outcome outcome = place.c3rt("plan push_t < '" + file + "'");
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("\"approach\"") && Contains("holding: t 0 is out of reach"));
}

TEST_CASE(
    "plan: a line that is wrong ends it, named by its number, its key and what was expected") {
  const cli::Place place;
  const Json good = scene_at(1.0, {0.4, 0.1, 0.1}, {0.55, 0.0, -0.0045}, 0.3);
  const auto with = [&](const char* pointer, const Json& value) {
    Json scene = good;
    scene["time_s"] = 2.0;
    scene[Json::json_pointer(pointer)] = value;
    return scene.dump();
  };
  Json none = good, both = good;
  none["time_s"] = both["time_s"] = 2.0;
  none["objects"][0].erase("yaw_rad");
  both["objects"][0]["orientation_wxyz"] = {1.0, 0.0, 0.0, 0.0};
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"{", "line 2"},
      {"[1, 2]", "line 2: : expected an object"},
      {good.dump(), "line 2: time_s: expected more than 1"},
      {with("/time_s", -1.0), "line 2: time_s"},
      {with("/time_s", "soon"), "line 2: time_s"},
      {with("/end_effector", 3), "line 2: end_effector"},
      {with("/end_effector/position_m", {0.4, 0.1}), "end_effector.position_m: expected"},
      {with("/end_effector/position_m", {0.4, 0.1, 1e9}), "end_effector.position_m: expected"},
      {with("/end_effector/speed", 1.0), "end_effector.speed"},
      {with("/objects", Json::array()), "line 2: objects: expected a list of the scenario's 1"},
      {with("/objects", {{"t", 1}}), "line 2: objects: expected a list"},
      {with("/objects/0/yaw_rad", "NaN"), "objects[0].yaw_rad"},
      {with("/objects/0/color", "red"), "objects[0].color"},
      {with("/more", 1), "line 2: more"},
      {none.dump(), "objects[0].yaw_rad: expected this or orientation_wxyz"},
      {both.dump(), "objects[0].yaw_rad: expected this or orientation_wxyz"},
      {R"({"time_s": 2, "time_s": 3})", "time_s"},
      {std::string(1 << 17, ' '), "line 2: expected at most"}};
  for (const auto& [line, expected] : wrong) {
    CAPTURE(line.substr(0, 200));
    const std::string file = (place.path() / "scenes.jsonl").string();
    std::ofstream(file) << good << "\n" << line << "\n";
    const support::Outcome outcome = place.c3rt("plan push_t < '" + file + "'");
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains(expected) && Contains("\"phase\":\"approach\""));
  }
  CHECK(place.c3rt("plan pivoting < /dev/null").status == 2);
  CHECK(place.c3rt("plan push_t < /dev/null").status == 0);
  CHECK_FALSE(place.started("planner"));
}
