// `c3rt campaign` as a person meets it, with real runs of a few simulated seconds.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/cli/eventually.hpp"
#include "tests/cli/folder.hpp"
#include "tests/support/outcome.hpp"

namespace {

using c3rt::cli::eventually;
using c3rt::cli::Folder;
using Catch::Contains;
using nlohmann::json;
namespace fs = std::filesystem;

using c3rt::support::Outcome;

std::string command(const Folder& folder, const std::string& arguments) {
  return "'" C3RT_BINARY_DIRECTORY "/bin/c3rt' campaign " + arguments + " --out '" +
         folder.path().string() + "'";
}

Outcome campaign(const Folder& folder, const std::string& arguments,
                 const std::string& environment = "") {
  return c3rt::support::outcome_of(environment + " " + command(folder, arguments));
}

json read(const fs::path& file) { return json::parse(std::ifstream(file)); }

/// Processes whose command line names the folder.
int processes_of(const fs::path& folder) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream stream(entry.path() / "cmdline");
    const std::string line{std::istreambuf_iterator<char>(stream), {}};
    count += line.find(folder.string()) != std::string::npos ? 1 : 0;
  }
  return count;
}

// too short for a circle: it runs, but does not meet its criteria
const std::string kShort = "circle_fast --duration 2 ";

}  // namespace

TEST_CASE("mistakes in a campaign are usage errors before anything is started") {
  const Folder folder;
  for (const auto& [arguments, says] :
       {std::pair{"no_such_scenario", "circle_slow"},
        {"circle_fast --seeds 5..1", "backwards"},
        {"circle_fast --set planner.no_such_key=1", "planner.no_such_key"},
        {"circle_fast --address tcp://a:1", "--engine dask"},
        {"circle_fast --jobs 0", "--jobs"},
        {"cart_pole --in-process", "numerical example"},
        {"circle_fast --engine ray", "--engine"}}) {
    CAPTURE(arguments);
    const Outcome outcome = campaign(folder, arguments);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains(says));
  }
  CHECK_FALSE(fs::exists(folder.path() / "seed-0001"));
}

TEST_CASE("two seeds at once: a report each, one table, and the same bits as alone; then kept") {
  const Folder folder, other;
  const Outcome first = campaign(folder, kShort + "--seeds 1..2 --jobs 2");
  CHECK(first.status == 1);
  CHECK_THAT(first.output, Contains("0 of 2 passed") && Contains("criterion loops_completed") &&
                               Contains("c3rt run circle_fast --clock lockstep --seed ") &&
                               Contains("--duration 2"));
  const json one = read(folder.path() / "seed-0001" / "report.json"),
             two = read(folder.path() / "seed-0002" / "report.json");
  CHECK(one.at("seed") == 1);
  CHECK(two.at("seed") == 2);
  CHECK(one.at("log_hash") != two.at("log_hash"));  // the noise
  const json table = read(folder.path() / "campaign.json");
  CHECK(table.at("complete") == true);
  CHECK(table.at("runs").size() == 2);
  CHECK(table.at("figures").at("objects.0.rms_error_m").at("count") == 2);
  CHECK(fs::exists(folder.path() / "campaign.md"));
  // neither logs nor pictures unless wanted
  CHECK_FALSE(fs::exists(folder.path() / "seed-0001" / "run.mcap"));
  CHECK_FALSE(fs::exists(folder.path() / "seed-0001" / "path.png"));

  const auto made = fs::last_write_time(folder.path() / "seed-0002" / "report.json");
  const Outcome again = campaign(folder, kShort + "--seeds 1..2 --jobs 2");
  CHECK(again.status == 1);
  CHECK_THAT(again.output, Contains("2 runs of an earlier call are kept"));
  CHECK(fs::last_write_time(folder.path() / "seed-0002" / "report.json") == made);
  // other settings are another run
  const Outcome changed = campaign(folder, kShort + "--seeds 2 --set planner.rate_hz=60");
  CHECK_THAT(changed.output, !Contains("kept"));
  CHECK(read(folder.path() / "seed-0002" / "report.json").at("log_hash") != two.at("log_hash"));

  CHECK(campaign(other, kShort + "--seeds 2 --jobs 1 --logs").status == 1);
  CHECK(read(other.path() / "seed-0002" / "report.json").at("log_hash") == two.at("log_hash"));
  CHECK(fs::exists(other.path() / "seed-0002" / "run.mcap"));
}

TEST_CASE("each run in one process gives the bits of four in lockstep") {
  const Folder apart, together;
  CHECK(campaign(apart, kShort + "--seeds 3").status == 1);
  const Outcome outcome = campaign(together, kShort + "--seeds 3,4 --jobs 2 --in-process");
  CHECK(outcome.status == 1);
  CHECK_THAT(outcome.output, Contains("c3rt run circle_fast --in-process --seed "));
  CHECK(read(together.path() / "seed-0003" / "report.json").at("log_hash") ==
        read(apart.path() / "seed-0003" / "report.json").at("log_hash"));
  // nobody else was started
  CHECK_FALSE(fs::exists(together.path() / "seed-0003" / "logs" / "plant.log"));
}

TEST_CASE("a run whose process fails is status 3, with the end of its log, and is made again") {
  const Folder folder;
  const fs::path programs = folder.path() / "bin";
  fs::create_directories(programs);
  for (const char* name : {"plant", "impedance", "planner", "vision"}) {
    const fs::path file = programs / (std::string("c3rt-") + name);
    std::ofstream(file) << "#!/bin/sh\necho 'no model here'; exit 1\n";
    fs::permissions(file, fs::perms::owner_all);
  }
  const Outcome failed =
      campaign(folder, kShort + "--seeds 1", "C3RT_PROCESS_DIRECTORY='" + programs.string() + "'");
  CHECK(failed.status == 3);
  CHECK_THAT(failed.output, Contains("exited with status 3") && Contains("no model here") &&
                                Contains("0 of 1 passed") && Contains("1 failed"));
  const Outcome again = campaign(folder, kShort + "--seeds 1");
  CHECK(again.status == 1);
  CHECK_THAT(again.output, !Contains("kept"));
}

TEST_CASE("Ctrl-C ends every process, keeps what is done, and the next call goes on from there") {
  const Folder folder;
  REQUIRE(campaign(folder, kShort + "--seeds 1").status == 1);
  const pid_t pid = fork();
  if (pid == 0) {
    // seed 1 is kept, the others would take minutes
    const std::string line = "exec " +
                             command(folder,
                                     "circle_fast --duration 2 --seeds 1..4 --jobs 2 --set "
                                     "timing.solve_time_s=0.0051") +
                             " >'" + (folder.path() / "said").string() + "' 2>&1";
    execl("/bin/bash", "bash", "-c", line.c_str(), nullptr);
    _exit(127);
  }
  REQUIRE(eventually([&] { return processes_of(folder.path() / "seed-") >= 2; }));
  kill(pid, SIGINT);
  int status = 0;
  waitpid(pid, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 1);
  CHECK(processes_of(folder.path()) == 0);
  std::ifstream said(folder.path() / "said");
  const std::string text{std::istreambuf_iterator<char>(said), {}};
  CHECK_THAT(text, Contains("interrupted after") && Contains("goes on from there"));
}

TEST_CASE("without Dask its engine is a usage error that says what to install") {
  const Folder folder;
  const Outcome outcome =
      campaign(folder, kShort + "--seeds 1 --engine dask", "C3RT_PYTHON=/bin/false");
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.output, Contains("python3-distributed") && Contains("C3RT_PYTHON"));
}

TEST_CASE("Dask makes the same runs on its workers") {
  bool found = false;
  for (const char* python : {"python3", "/usr/bin/python3"})
    found = found ||
            std::system(
                (std::string(python) + " -c 'import distributed' >/dev/null 2>&1").c_str()) == 0;
  if (!found) {
    WARN("left out: no Python here has the package distributed (Debian: python3-distributed)");
    return;
  }
  const Folder folder, here;
  const Outcome outcome = campaign(folder, kShort + "--seeds 1..2 --jobs 2 --engine dask");
  INFO(outcome.output);
  CHECK(outcome.status == 1);
  REQUIRE(campaign(here, kShort + "--seeds 2").status == 1);
  CHECK(read(folder.path() / "seed-0002" / "report.json").at("log_hash") ==
        read(here.path() / "seed-0002" / "report.json").at("log_hash"));
  CHECK_THAT(campaign(folder, kShort + "--seeds 1..2 --jobs 2 --engine dask").output,
             Contains("2 runs of an earlier call are kept"));
  // a scheduler that is not there
  const Outcome nobody =
      campaign(here, kShort + "--seeds 3 --engine dask --address tcp://127.0.0.1:9");
  CHECK(nobody.status == 2);
  CHECK_THAT(nobody.output, Contains("tcp://127.0.0.1:9"));
}
