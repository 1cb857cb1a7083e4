// The command as a person meets it: the installed program, with small shells in the place of the
// four processes.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/lock.hpp"
#include "tests/cli/eventually.hpp"
#include "tests/cli/folder.hpp"
#include "tests/cli/place.hpp"
#include "tests/support/outcome.hpp"

namespace {

using namespace c3rt::cli;
using Catch::Contains;
namespace fs = std::filesystem;

constexpr int kDomain = 97;

using c3rt::support::Outcome;

}  // namespace

TEST_CASE("an unknown scenario is a usage error that lists the known ones") {
  const Outcome outcome = Place().c3rt("run no_such_scenario");
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output,
             Contains("unknown scenario \"no_such_scenario\"") && Contains("circle_slow"));
}

TEST_CASE("an override of a key that does not exist is a usage error that names the key") {
  const Outcome outcome = Place().c3rt("run circle_slow --set planner.no_such_key=1");
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output, Contains("planner.no_such_key"));
}

TEST_CASE("an override out of range is a usage error that says what was expected") {
  const Outcome outcome = Place().c3rt("run circle_slow --set planner.rate_hz=-3");
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output, Contains("planner.rate_hz") && Contains("expected"));
}

TEST_CASE("a numerical example runs in this process and leaves report, table and picture") {
  const Place place;
  const std::string out = " --out '" + place.out().string() + "'";
  // too short to come to rest: it runs, but does not meet its criterion
  const Outcome failed = place.c3rt("run cart_pole --duration 0.5" + out);
  CHECK(failed.status == 1);
  CHECK_THAT(failed.output, Contains("criteria not met") && Contains("success_rate: 0"));
  CHECK(place.c3rt("run cart_pole" + out).status == 0);
  for (const char* name : {"report.json", "trajectory.csv", "trajectory.png"})
    CHECK(fs::exists(place.out() / name));
  CHECK_FALSE(place.started("plant"));
}

TEST_CASE("a numerical example refuses the options of the four processes, and to be a service") {
  const Place place;
  for (const char* option : {"--clock lockstep", "--domain 3", "--dds lan"}) {
    const Outcome outcome = place.c3rt(std::string("run cart_pole ") + option);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains("numerical example"));
  }
  const Outcome service = place.c3rt("up pivoting" + place.start_options());
  CHECK(service.status == 2);
  CHECK_THAT(service.output, Contains("numerical example"));
}

TEST_CASE("a word that is no command, and no word at all, are usage errors in a plain sentence") {
  const Outcome unknown = Place().c3rt("staus");
  CHECK(unknown.status == 2);
  CHECK_THAT(unknown.output, Contains("there is no command \"staus\"; did you mean \"status\"?"));
  const Outcome none = Place().c3rt("");
  CHECK(none.status == 2);
  CHECK_THAT(none.output, Contains("a command is missing, one of: run, "));
  const Outcome half = Place().c3rt("fault");
  CHECK(half.status == 2);
  CHECK_THAT(half.output, Contains("c3rt fault: a command is missing, one of: push-object"));
}

TEST_CASE("numbers out of range, NaN and words that are not known are refused in one plain line") {
  const Place place;
  for (const auto& [arguments, said] : std::vector<std::pair<std::string, std::string>>{
           {"echo plan -n -1", "--count: expected a whole number from 0 to 1000000000, got \"-1\""},
           {"target circle --radius nan", "--radius: expected a number from 0 to"},
           {"target circle --center nan 0", "--center: expected a number from"},
           {"target circle --lead-deg inf", "--lead-deg: expected a number from"},
           {"target pose 0.5 nan", "goals: expected a number from"},
           {"target pose 0.5 0 --yaw-deg inf", "--yaw-deg: expected a number from"},
           {"target path 0.5 0 nan 0", "points: expected a number from"},
           {"target line --end nan", "--end: expected a number from"},
           {"target pose 0.5 0 0.6",
            "goals_m: expected 1 to 32 times 2 numbers from -1 to 1, got 3"},
           {"target path 0.5 0", "points_m: expected 2 to 1000 times 2 numbers"},
           {"weights set roll.R=much", "expected NAME=VALUE with a number, got \"roll.R=much\""},
           {"weights set roll.R=1,2", "expected NAME=VALUE with a number, got \"roll.R=1,2\""},
           {"weights set roll.R", "expected NAME=VALUE with a number, got \"roll.R\""},
           {"target task spiral", "one of circle, path, line, pose, got \"spiral\""},
           {"target task circle radius_m", "expected a parameter as KEY=VALUE"},
           {"target task circle radius_m=0.1", "center_m: expected 2 numbers from -1 to 1"},
           {"target task circle center_m=0.5,0 radius_m=wide lead_rad=0.3",
            "radius_m: expected a number from 0.01 to 0.5, got \"wide\""},
           {"target line --step 0", "step_m: expected a step that is not 0, got 0"},
           {"target pose 5 0", "goals_m: expected 1 to 32 times 2 numbers from -1 to 1, got 5"},
           {"fault push-object --impulse 0 1e999 0", "--impulse: expected a number from"},
           {"fault stall plant --for nan", "--for: expected a number from"},
           {"fault nan plantt", "one of impedance, planner, plant, vision, got \"plantt\"; did"},
           {"robot guide --axes x,w", "one of x, y, z, roll, pitch, yaw, got \"w\""},
           {"robot user-stop push", "one of press, release, got \"push\""},
           {"robot push --force 300 0 0", "force_W_n[0] is 300, expected -200 to 200"},
           {"robot thresholds --collision-torque 20 20 --collision-force 20",
            "--collision-torque: expected 1 or 7 numbers, got 2"},
           {"robot thresholds --collision-torque 20 --collision-force 20 --contact-force 25",
            "acceleration.contact_force_E_n[0] is 25, expected 0 to 20"},
           {"run circle_slow --duration nan", "--duration: expected a number from"},
           {"run circle_slow --seed 1.5", "--seed: expected a whole number from 0"},
           {"run circle_slow --domain 231", "a whole number from 0 to 230, or any, got \"231\""},
           {"campaign circle_slow --jobs 0", "--jobs: expected a whole number from 1 to"},
           {"run circle_slow --exact 1",
            "--exact, --trace: of numerical examples, circle_slow is none"},
           {"run cart_pole --exact 1 --trace", "--trace: of C3 alone"},
           {"gap cart_pole --planner circle_slow",
            "--planner: expected a numerical example, got circle_slow"},
           {"gap push_t", "expected a problem file (.json), a recording (.mcap) or a numerical"},
           {"reproduce table1 --miqp-limit nan", "--miqp-limit: expected a number from"},
           {"status --dommain 3", "there is no option \"--dommain\"; did you mean \"--domain\"?"},
           {"down now", "\"now\" is one word too many"},
           {"echo 'a\033[31m' b", "\"b\" is one word too many"}}) {
    CAPTURE(arguments);
    const Outcome outcome = place.c3rt(arguments);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains(said));
    CHECK(std::count(outcome.output.begin(), outcome.output.end(), '\n') == 1);
    CHECK(outcome.output.size() < 300);
  }
}

TEST_CASE("every command's help shows at least two examples, all of that command") {
  const Place place;
  for (const std::string command : {"run",
                                    "up",
                                    "serve",
                                    "down",
                                    "status",
                                    "recover",
                                    "stop",
                                    "fault",
                                    "fault push-object",
                                    "fault drop-commands",
                                    "fault freeze-camera",
                                    "fault lose-object",
                                    "fault stall",
                                    "fault nan",
                                    "fault none",
                                    "robot",
                                    "robot thresholds",
                                    "robot guide",
                                    "robot release",
                                    "robot user-stop",
                                    "robot push",
                                    "target",
                                    "target circle",
                                    "target path",
                                    "target line",
                                    "target pose",
                                    "target task",
                                    "target hold",
                                    "target scenario",
                                    "weights",
                                    "weights list",
                                    "weights set",
                                    "weights scenario",
                                    "topics",
                                    "echo",
                                    "hz",
                                    "replay",
                                    "soak",
                                    "campaign",
                                    "reproduce",
                                    "solve",
                                    "bench"}) {
    CAPTURE(command);
    const Outcome help = place.c3rt(command + " --help");
    CHECK(help.status == 0);
    const std::size_t at = help.output.find("Examples:\n");
    REQUIRE(at != std::string::npos);
    std::istringstream lines(help.output.substr(at + 10));
    int own = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("  c3rt ", 0) != 0) continue;
      CHECK(line.rfind("  c3rt " + command, 0) == 0);
      ++own;
    }
    CHECK(own >= 2);
  }
}

TEST_CASE("help and version succeed") {
  const Outcome help = Place().c3rt("--help");
  CHECK(help.status == 0);
  CHECK_THAT(help.output, Contains("Examples:") && Contains("Exit status"));
  CHECK(Place().c3rt("--version").status == 0);
  CHECK(Place().c3rt("run --help").status == 0);
}

TEST_CASE("a second instance on a busy domain is refused and told who holds it") {
  const Place place;
  Instance other;
  other.pid = getpid();
  other.verb = "up";
  other.scenario = "circle_fast";
  const DomainLock lock(place.locks(), kDomain, other);
  const Outcome outcome = place.c3rt("run circle_slow" + place.start_options());
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output, Contains("domain 97 is busy") && Contains("c3rt up circle_fast"));
  CHECK_FALSE(place.started("plant"));
}

TEST_CASE("a missing program is a usage error") {
  const Place place;
  fs::remove(place.pid_file("vision").parent_path() / "bin" / "c3rt-vision");
  const Outcome outcome = place.c3rt("run circle_slow" + place.start_options());
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output, Contains("c3rt-vision"));
}

TEST_CASE(
    "a process that crashes in a run is named with the end of its log, and nothing is left "
    "behind") {
  const Place place;
  place.process("planner", "echo 'the matrix is not finite'; kill -SEGV $$");
  const Outcome outcome = place.c3rt("run circle_slow" + place.start_options());
  CHECK(outcome.status == 3);
  CHECK_THAT(outcome.output,
             Contains("planner was killed by signal 11") && Contains("the matrix is not finite"));
  CHECK(place.empty());
  CHECK(fs::exists(place.out() / "report.json"));  // also a run that failed is reported
}

TEST_CASE("SIGTERM ends a run, and nothing is left behind") {
  const Place place;
  const std::string command =
      "exec env " + place.command("run circle_slow" + place.start_options());
  const pid_t pid = fork();
  if (pid == 0) {
    execl("/bin/bash", "bash", "-c", (command + " >/dev/null 2>&1").c_str(), nullptr);
    _exit(127);
  }
  REQUIRE(eventually([&] { return place.started("vision"); }));
  kill(pid, SIGTERM);
  int status = 0;
  waitpid(pid, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 1);
  CHECK(place.empty());
  CHECK_FALSE(holder(place.locks(), kDomain).has_value());
}

TEST_CASE("a process that crashes while the service comes up is named") {
  const Place place;
  place.process("impedance", "echo 'no model'; exit 2");
  const Outcome outcome = place.c3rt("up circle_slow" + place.start_options());
  CHECK(outcome.status == 3);
  CHECK_THAT(outcome.output, Contains("impedance exited with status 2") && Contains("no model"));
  CHECK(place.empty());
}

TEST_CASE("down where nothing runs succeeds, status says that nothing runs") {
  const Place place;
  CHECK(place.c3rt("down --domain 97").status == 0);
  const Outcome outcome = place.c3rt("status --domain 97");
  CHECK(outcome.status == 1);
  CHECK_THAT(outcome.output, Contains("nothing runs"));
}

TEST_CASE("an unknown topic is a usage error that lists the known ones") {
  const Outcome outcome = Place().c3rt("echo object/velocity --domain 97");
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output, Contains("object/estimate"));
}

TEST_CASE("c3rt scenario prints a scenario whole, so that the print can be run in its place") {
  const Place place;
  const Outcome outcome = place.c3rt("scenario circle_fast --set planner.rate_hz=75");
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.output,
             Catch::StartsWith("name: circle_fast") && Contains("# circle_fast.yaml:2\n"));
  CHECK_THAT(outcome.output, Contains("  rate_hz: 75") && Contains("# --set\n"));
  CHECK_THAT(outcome.output,
             Contains("  speed_limit_m_per_s: 0.2") && Contains("# circle_slow.yaml:"));
  CHECK_THAT(outcome.output, !Contains("extends"));
  const std::string mine = (place.path() / "mine.yaml").string();
  std::ofstream(mine) << outcome.output;
  const Outcome again = place.c3rt("scenario '" + mine + "'");
  CHECK(again.status == 0);
  const auto without_comments = [](const std::string& text) {
    std::istringstream lines(text);
    std::string bare;
    for (std::string line; std::getline(lines, line);) {
      line.erase(std::min(line.find(" # "), line.size()));
      line.erase(line.find_last_not_of(' ') + 1);
      bare += line + "\n";
    }
    return bare;
  };
  CHECK(without_comments(again.output) == without_comments(outcome.output));
  CHECK(place.c3rt("scenario cart_pole").status == 0);
}

TEST_CASE("c3rt scenario --json: both texts, every value, and the files that values name") {
  const Place place;
  const fs::path file = place.path() / "own.yaml";
  fs::copy(C3RT_SOURCE_DIRECTORY "/config/objects/t.xml", place.path() / "own.xml");
  std::ofstream(file) << "name: own\ndescription: own\nextends: push_t\n"
                         "plant:\n  objects: [{mjcf: own.xml, position_m: [0.55, 0.0], "
                         "start_spread_xy_m: [0.15, 0.15], yaw_spread_rad: 3.1415, "
                         "friction_table: 0.4, friction_end_effector: 0.5}]\n";
  const auto told = [&place](const std::string& arguments) {
    const Outcome outcome = place.c3rt("scenario " + arguments + " --json");
    REQUIRE(outcome.status == 0);
    return nlohmann::ordered_json::parse(outcome.output);
  };
  const auto own = told("'" + file.string() + "' --set planner.rate_hz=40");
  CHECK(own.at("file") == file.string());
  CHECK(own.at("is_example") == false);
  CHECK(own.at("values").at("planner").at("rate_hz") == "40");
  CHECK(own.at("values").at("plant").at("objects").at(0).at("mjcf") == "own.xml");
  // each can be read in its place: the one with what was set, the other without
  for (const auto& [name, is_set] : {std::pair{"text", true}, {"own_text", false}}) {
    const std::string text = own.at(name);
    CHECK((text.find("rate_hz: 40") != std::string::npos) == is_set);
    std::ofstream(place.path() / "again.yaml") << text;
    CHECK(place.c3rt("scenario '" + (place.path() / "again.yaml").string() + "'").status == 0);
  }
  // beside the scenario; the planner's model is what push_t says, beside that one
  const std::vector<std::string> files = own.at("files");
  const auto is_named = [&files](const fs::path& wanted) {
    return std::any_of(files.begin(), files.end(), [&wanted](const std::string& one) {
      return fs::weakly_canonical(one) == fs::weakly_canonical(wanted);
    });
  };
  CHECK(is_named(place.path() / "own.xml"));
  CHECK(is_named(C3RT_SOURCE_DIRECTORY "/config/objects/t.xml"));
  CHECK_FALSE(is_named(C3RT_SOURCE_DIRECTORY "/config/objects/l.xml"));
  CHECK(told("cart_pole").at("is_example") == true);
  CHECK(place.c3rt("scenario circle_fast --set planner.no_such_key=1 --json").status == 2);
  CHECK(place.c3rt("scenario --json").status == 2);
}

TEST_CASE("c3rt scenario without a name lists every file of the folder with its description") {
  const Outcome outcome = Place().c3rt("scenario");
  CHECK(outcome.status == 0);
  for (const auto& entry : fs::directory_iterator(C3RT_SOURCE_DIRECTORY "/config/scenarios"))
    CHECK_THAT(outcome.output, Contains(entry.path().stem().string() + " "));
}

TEST_CASE("c3rt scenario refuses what c3rt run would, by file and line") {
  const Place place;
  const std::string mine = (place.path() / "mine.yaml").string();
  std::ofstream(mine)
      << "name: mine\ndescription: own\nextends: circle_fast\nplanner:\n  horizon: 99\n";
  for (const std::string verb : {"scenario", "run"}) {
    const Outcome outcome = place.c3rt(verb + " '" + mine + "'");
    CHECK(outcome.status == 2);
    CHECK_THAT(
        outcome.output,
        Contains("mine.yaml:5: planner.horizon: expected an integer in [1, 10], got \"99\""));
  }
  CHECK(place.c3rt("scenario no_such_scenario").status == 2);
  CHECK(place.c3rt("scenario circle_fast --set planner.no_such_key=1").status == 2);
}
