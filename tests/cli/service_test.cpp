// The service as a person meets it: the built program, with stubs in the place of the four
// processes that say on the bus that they run.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>

#include <catch2/catch.hpp>

#include "cli/lock.hpp"
#include "cli/paths.hpp"
#include "tests/cli/eventually.hpp"
#include "tests/cli/place.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/small_disk.hpp"

namespace {

using namespace c3rt::cli;
using c3rt::support::Outcome;
using Catch::Contains;
namespace fs = std::filesystem;

constexpr int kDomain = 96;

/// A place whose processes speak on the bus; what it started ends with it.
class Service : public Place {
 public:
  Service() : Place(kDomain) {
    for (const char* name : {"plant", "impedance", "planner", "vision"}) stub(name);
    for (const char* runtime : {"run", "other"}) fs::create_directories(path() / runtime / "c3rt");
  }
  ~Service() { c3rt("down" + on_domain()); }
  void stub(const std::string& name) const {
    process(name, "exec -a c3rt-" + name + " '" C3RT_STUB_PROCESS "' \"$@\"");
  }
  Outcome up(const std::string& runtime = "run") const {
    const Outcome outcome = c3rt("up circle_slow" + start_options(), runtime);
    // the supervisor counts the four by itself: a death before that is one at the start
    std::this_thread::sleep_for(std::chrono::seconds(1));
    return outcome;
  }
};

}  // namespace

TEST_CASE("service: a process that is killed is started again, and status tells") {
  const Service service;
  REQUIRE(service.up().status == 0);
  for (const std::string name : {"planner", "vision", "impedance", "plant"}) {
    CAPTURE(name);
    const pid_t before = service.pid(name);
    REQUIRE(kill(before, SIGKILL) == 0);
    REQUIRE(eventually([&] { return service.pid(name) > 0 && service.pid(name) != before; }));
    Outcome status{};
    CHECK(eventually([&] {
      status = service.c3rt("status" + service.on_domain());
      return status.status == 0;
    }));
    CHECK_THAT(status.output, Contains(name + " was started again once (was killed by signal 9"));
  }
  CHECK(service.c3rt("down" + service.on_domain()).status == 0);
  CHECK(service.empty());
}

TEST_CASE(
    "service: a robot that stopped for a death is recovered, one that a person stopped is not") {
  const Service service;
  REQUIRE(service.up().status == 0);
  const auto plant_says = [&](const std::string& text) {
    return service.c3rt("status" + service.on_domain()).output.find(text) != std::string::npos;
  };
  const auto kill_impedance = [&] {
    const pid_t before = service.pid("impedance");
    REQUIRE(kill(before, SIGKILL) == 0);
    REQUIRE(eventually([&] { return service.pid("impedance") != before; }));
  };
  kill_impedance();
  const fs::path log = service.locks() / "supervisor-96.log";
  CHECK(eventually([&] {
    return tail(log, 50).find("the robot goes on after impedance was started again") !=
           std::string::npos;
  }));
  CHECK_FALSE(plant_says("reflex"));
  REQUIRE(service.c3rt("stop" + service.on_domain()).status == 0);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  kill_impedance();
  CHECK(eventually([&] { return plant_says("impedance was started again 2 times"); }));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  CHECK((plant_says("reflex: of the stub") || plant_says("stopped by a person")));
}

TEST_CASE("service: a planner that is started again is told the last target that was taken") {
  const Service service;
  REQUIRE(service.up().status == 0);
  const auto planner_says = [&](const std::string& text) {
    return eventually([&] {
      return service.c3rt("status" + service.on_domain()).output.find(text) != std::string::npos;
    });
  };
  const std::string taken = "a stub, told target circle with radius_m 0.080000";
  REQUIRE(
      service.c3rt("target circle --center 0.55 0 --radius 0.08" + service.on_domain()).status ==
      0);
  REQUIRE(planner_says(taken));
  // refused, so not the last that was taken
  REQUIRE(service.c3rt("target pose 0.55 0" + service.on_domain()).status == 1);
  REQUIRE(planner_says("a stub, told target pose"));
  for (int i = 0; i < 3; ++i) {
    CAPTURE(i);
    // the second one dies while a person has stopped the robot, the third together with vision
    if (i == 1) REQUIRE(service.c3rt("stop" + service.on_domain()).status == 0);
    if (i == 1) std::this_thread::sleep_for(std::chrono::seconds(1));
    const pid_t before = service.pid("planner");
    REQUIRE(kill(before, SIGKILL) == 0);
    if (i == 2) kill(service.pid("vision"), SIGKILL);
    REQUIRE(eventually([&] { return service.pid("planner") != before; }));
    CHECK(planner_says(taken));
  }
}

TEST_CASE("service: a process that ends again and again is given up, the others go on") {
  const Service service;
  REQUIRE(service.up().status == 0);
  service.process("vision", "echo 'no camera'; exit 1");
  REQUIRE(kill(service.pid("vision"), SIGKILL) == 0);
  Outcome status{};
  CHECK(eventually([&] {
    status = service.c3rt("status" + service.on_domain());
    return status.output.find("given up") != std::string::npos;
  }));
  CHECK(status.status == 3);
  CHECK_THAT(status.output, Contains("vision was started again 5 times (exited with status 1)"));
  CHECK(kill(service.pid("plant"), 0) == 0);
  CHECK(service.c3rt("down" + service.on_domain()).status == 0);
  CHECK(service.empty());
}

TEST_CASE("service: on a domain in use another user's instance is refused and told whose it is") {
  const Service service;
  REQUIRE(service.up().status == 0);
  for (const std::string verb : {"up", "run"}) {
    const Outcome refused = service.c3rt(verb + " circle_slow" + service.on_domain() + " --out '" +
                                             (service.path() / "o").string() + "'",
                                         "other");
    CHECK(refused.status == 2);
    CHECK_THAT(refused.output,
               Contains("DDS domain 96 is busy: ") && Contains("pid ") && Contains("user "));
  }
  const Outcome status = service.c3rt("status" + service.on_domain(), "other");
  CHECK_THAT(status.output, Contains("not yours") && Contains("user ") && Contains("running"));
  const Outcome down = service.c3rt("down" + service.on_domain(), "other");
  CHECK(down.status == 1);
  CHECK_THAT(down.output, Contains("not yours") && Contains("user "));
  CHECK(service.c3rt("status" + service.on_domain()).status ==
        0);  // and nothing has happened to it
}

TEST_CASE("service: a process that is left out is a client's, before or after the others") {
  const Service service;
  const auto client = [] {
    return c3rt::test::ChildProcess(
        {"/bin/bash", "-c",
         "exec -a c3rt-planner '" C3RT_STUB_PROCESS "' '" C3RT_SOURCE_DIRECTORY
         "/config/scenarios/circle_slow.yaml' --domain=96 --dds-profile='" C3RT_SOURCE_DIRECTORY
         "/config/dds/loopback.xml'"});
  };
  const std::string up = "up circle_slow --without planner" + service.start_options();
  const auto status = [&] { return service.c3rt("status" + service.on_domain()); };
  const Outcome after = service.c3rt(up);
  REQUIRE(after.status == 0);
  CHECK_THAT(after.output, Contains("waits for planner: yours, on domain 96, profile loopback"));
  CHECK(service.started("vision"));
  CHECK_FALSE(service.started("planner"));
  CHECK(status().status == 3);  // nobody plans
  {
    const auto planner = client();
    CHECK(eventually([&] { return status().status == 0; }));
    CHECK(service.c3rt("down" + service.on_domain()).status == 0);
    CHECK(service.empty());

    const Outcome before = service.c3rt(up);
    INFO(before.output);
    REQUIRE(before.status == 0);  // it is there already
    CHECK(status().status == 0);
    CHECK(service.c3rt("down" + service.on_domain()).status == 0);
    const Outcome busy = service.c3rt("up circle_slow" + service.start_options());
    CHECK(busy.status == 2);
    CHECK_THAT(busy.output, Contains("DDS domain 96 is busy"));
  }
  const Outcome nonsense = service.c3rt("run circle_slow --without planner,moon --in-process");
  CHECK(nonsense.status == 2);
  const Outcome in_process = service.c3rt("run circle_slow --without planner --in-process");
  CHECK(in_process.status == 2);
  CHECK_THAT(in_process.output, Contains("--without: --in-process runs without DDS"));
}

TEST_CASE("service: after everything was killed it comes up again at once") {
  const Service service;
  for (int i = 0; i < 2; ++i) {
    const Outcome up = service.up();
    INFO(up.output);
    REQUIRE(up.status == 0);
    const auto instance = holder(service.locks(), kDomain);
    REQUIRE(instance.has_value());
    REQUIRE(kill(instance->pid, SIGKILL) == 0);
  }
}

TEST_CASE("service: hz tells keys and writers apart, topics shows who reads and writes what") {
  const Service service;
  REQUIRE(service.up().status == 0);
  const Outcome hz = service.c3rt("hz service/status --count 3" + service.on_domain());
  CHECK(hz.status == 0);
  for (const char* name : {"plant", "impedance", "planner", "vision"})
    CHECK_THAT(hz.output, Contains(std::string(name) + ", "));
  CHECK_THAT(hz.output, !Contains("min -"));
  const Outcome topics = service.c3rt("topics --peers" + service.on_domain());
  CHECK(topics.status == 0);
  CHECK_THAT(topics.output, Contains("c3rt::v2::RobotState") &&
                                Contains("writers readers  rate Hz") &&
                                Contains("best effort, volatile, keep last 1, deadline 20 ms") &&
                                Contains("writer ") && Contains("reader ") && Contains("a stub"));
}

TEST_CASE("service: echo and hz say that nobody writes, after a bounded time") {
  const Place place(kDomain);
  for (const std::string tool : {"echo", "hz"}) {
    for (const std::string topic : {"plan", "task/target"}) {
      const Outcome outcome = place.c3rt(tool + " " + topic + " --timeout 0.5" + place.on_domain());
      CHECK(outcome.status == 1);
      CHECK_THAT(outcome.output,
                 Contains("nobody has written " + topic + " on domain 96 for 0.5 s"));
    }
  }
}

TEST_CASE("service: a DDS profile that is wrong is one line and status 2, and nothing starts") {
  const Place place(kDomain);
  const auto profile = [&](const std::string& text) {
    const fs::path file = place.path() / "profile.xml";
    std::ofstream(file) << text;
    return file.string();
  };
  const std::string begin = "<CycloneDDS><Domain Id=\"any\">", end = "</Domain></CycloneDDS>";
  for (const std::string& text :
       {begin + "<General><Interfaces><NetworkInterface name=\"nosuch7\"/></Interfaces></General>" +
            end,
        begin + "<General><NoSuchElement>1</NoSuchElement></General>" + end, begin + "<General>",
        std::string("this is no XML"), std::string()}) {
    CAPTURE(text);
    const std::string file = profile(text);
    for (const std::string verb : {"run circle_slow", "up circle_slow", "status", "echo plan"}) {
      CAPTURE(verb);
      const Outcome outcome = place.c3rt(
          verb + " --dds '" + file + "'" +
          (verb.find("circle") != std::string::npos ? place.start_options() : place.on_domain()));
      INFO(outcome.output);
      CHECK(outcome.status == 2);
      const std::size_t error = outcome.output.find("c3rt: error: DDS profile " + file);
      REQUIRE(error != std::string::npos);
      CHECK(std::count(outcome.output.begin() + static_cast<std::ptrdiff_t>(error),
                       outcome.output.end(), '\n') == 1);
    }
  }
  CHECK_FALSE(place.started("plant"));
  const Outcome missing = place.c3rt("run circle_slow --dds nosuch" + place.start_options());
  CHECK(missing.status == 2);
  CHECK_THAT(missing.output, Contains("unknown DDS profile \"nosuch\""));
}

TEST_CASE("service: where a domain has no room for another program, the limit is named") {
  const Place place(kDomain);
  std::ifstream loopback(C3RT_SOURCE_DIRECTORY "/config/dds/loopback.xml");
  std::string text{std::istreambuf_iterator<char>(loopback), {}};
  const std::string limit = "<MaxAutoParticipantIndex>119<";
  REQUIRE(text.find(limit) != std::string::npos);
  text.replace(text.find(limit), limit.size(), "<MaxAutoParticipantIndex>1<");
  const std::string profile = (place.path() / "one.xml").string();
  std::ofstream(profile) << text;
  const std::string options = place.on_domain() + " --dds '" + profile + "'";
  const Outcome outcome = c3rt::support::outcome_of(
      place.command("echo plan --timeout 60" + options) +
      " >/dev/null 2>&1 & first=$!; for i in $(seq 100); do sleep 0.1; " +
      place.command("status" + options) +
      "; status=$?; [ $status = 2 ] && break; done; kill $first; exit $status");
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output, Contains("as many programs use the domain as the profile allows "
                                      "(MaxAutoParticipantIndex; 119 with the profile loopback)"));
}

TEST_CASE("service: on a full disk nothing is started, and it is said at once") {
  const c3rt::test::SmallDisk disk;
  if (!disk.mounted()) {
    WARN("no file system can be mounted here");
    return;
  }
  std::ofstream(disk.path() / "filler") << std::string(600000, 'x');
  const Service service;
  for (const std::string verb : {"up", "run"}) {
    const Outcome outcome = service.c3rt(verb + " circle_slow" + service.on_domain() + " --out '" +
                                         disk.path().string() + "'");
    CHECK(outcome.status == 3);
    CHECK_THAT(outcome.output,
               Contains("no room for logs and results in ") && Contains("No space left on device"));
  }
  CHECK_FALSE(service.started("plant"));
}

TEST_CASE("service: a disk that fills while the service runs is told by status") {
  const c3rt::test::SmallDisk disk("2m");
  if (!disk.mounted()) {
    WARN("no file system can be mounted here");
    return;
  }
  const Service service;
  REQUIRE(
      service.c3rt("up circle_slow" + service.on_domain() + " --out '" + disk.path().string() + "'")
          .status == 0);
  std::ofstream(disk.path() / "filler") << std::string(3000000, 'x');
  CHECK(eventually([&] {
    return service.c3rt("status" + service.on_domain()).output.find("no room is left") !=
           std::string::npos;
  }));
}

TEST_CASE("service: without matplotlib there are no pictures, one warning, and everything else") {
  const Place place;
  const Outcome outcome = c3rt::support::outcome_of(
      "export C3RT_PYTHON=/bin/false; " +
      place.command("run cart_pole --duration 0.5 --out '" + place.out().string() + "'"));
  CHECK(outcome.status == 1);  // too short for its criterion
  CHECK_THAT(outcome.output,
             Contains("c3rt: no trajectory.png: no Python with the package matplotlib (looked at: "
                      "/bin/false); install it (Debian: python3-matplotlib; pip: matplotlib)"));
  CHECK(fs::exists(place.out() / "report.json"));
  CHECK(fs::exists(place.out() / "trajectory.csv"));
}

TEST_CASE("service: a Python that hangs or fails costs a bounded time and the pictures") {
  const Place place;
  const auto with_python = [&](const std::string& script) {
    const fs::path file = place.path() / "python3";
    // it says that it has the package
    std::ofstream(file) << "#!/bin/sh\n[ \"$1\" = -c ] && exit 0\n" << script << "\n";
    fs::permissions(file, fs::perms::owner_all);
    return c3rt::support::outcome_of(
        "export C3RT_PYTHON='" + file.string() + "'; " +
        place.command("run cart_pole --duration 0.5 --out '" + place.out().string() + "'"));
  };
  const Outcome failed = with_python("echo Traceback; echo 'ImportError: numpy' >&2; exit 1");
  CHECK(failed.status == 1);
  CHECK_THAT(failed.output, Contains("c3rt: no trajectory.png: ") &&
                                Contains("python3 exited with status 1: ImportError: numpy"));
  const Outcome silent = with_python("exit 0");
  CHECK_THAT(silent.output, Contains("python3 exited with status 0"));
  const Outcome hangs =
      with_python("touch '" + (place.out() / "trajectory.png.part").string() + "'; exec sleep 300");
  CHECK(hangs.status == 1);
  CHECK_THAT(hangs.output, Contains("python3 did not end within 25 s"));
  CHECK(fs::exists(place.out() / "report.json"));
  CHECK_FALSE(fs::exists(place.out() / "trajectory.png.part"));
}
