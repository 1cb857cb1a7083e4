// find_package(c3rt) as a stranger meets it: the library is installed into an empty prefix, and a
// project outside of this one (tests/package) is configured against it, built and run.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/outcome.hpp"

namespace {

namespace fs = std::filesystem;

void succeed(const std::string& command) {
  const c3rt::support::Outcome outcome = c3rt::support::outcome_of(command);
  INFO(command << "\n" << outcome.output);
  REQUIRE(outcome.status == 0);
}

std::string quoted(const fs::path& path) { return "'" + path.string() + "'"; }

double golden_u_0(const std::string& id) {
  nlohmann::json file;
  std::ifstream(C3RT_SOURCE_DIRECTORY "/tests/data/golden/cartpole.json") >> file;
  for (const auto& one : file.at("cases")) {
    if (one.at("id") == id) return one.at("u0").at(0).get<double>();
  }
  throw std::runtime_error("no golden case " + id);
}

/// Builds a target of the consumer's project.
c3rt::support::Outcome build(const std::string& target) {
  return c3rt::support::outcome_of(
      std::string("'") + C3RT_CMAKE + "' --build " +
      quoted(fs::path(C3RT_BINARY_DIRECTORY) / "package_test/consumer") + " --target " + target);
}

std::vector<std::string> words(const std::string& list) {
  std::istringstream stream(list);
  return {std::istream_iterator<std::string>(stream), {}};
}

bool can_run(const std::string& consumer) {
  return consumer.rfind("v3", 0) != 0 ||
         (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
          __builtin_cpu_supports("bmi2"));
}

}  // namespace

TEST_CASE("package: programs with any flags build, run and print the same bits") {
  const fs::path build_tree(C3RT_BINARY_DIRECTORY), scratch = build_tree / "package_test";
  const fs::path prefix = scratch / "prefix", consumer = scratch / "consumer";
  fs::remove_all(scratch);
  const std::string cmake = std::string("'") + C3RT_CMAKE + "'";

  succeed(cmake + " --install " + quoted(build_tree) + " --component library --prefix " +
          quoted(prefix));
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(prefix)) {
    // nothing in the prefix may lead back to where it was built
    if (entry.path().extension() != ".cmake") continue;
    INFO(entry.path().string());
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    CHECK(text.find(C3RT_SOURCE_DIRECTORY) == std::string::npos);
    CHECK(text.find(C3RT_BINARY_DIRECTORY) == std::string::npos);
  }
  const std::string flags =
      " -DCMAKE_PREFIX_PATH=" + quoted(prefix) + " " + std::string(C3RT_CONSUMER_FLAGS);
  const std::vector<std::string> consumers = words(C3RT_CONSUMERS);
  std::string list;
  for (const std::string& one : consumers) list += one + ";";
  succeed(cmake + " -S " + quoted(fs::path(C3RT_SOURCE_DIRECTORY) / "tests/package") + " -B " +
          quoted(consumer) + " '-Dconsumers=" + list + "'" + flags);
  succeed(cmake + " --build " + quoted(consumer));

  // a client, and the examples of a planner, an estimator and a camera of one's own
  const c3rt::support::Outcome refused_domain =
      c3rt::support::outcome_of(quoted(consumer / "client") + " 231");
  CHECK(refused_domain.output == "domain: expected 0 to 230, got 231\n");
  for (const std::string example : {"cpp_planner", "cpp_estimator", "cpp_mover"}) {
    const fs::path built = scratch / example;
    succeed(cmake + " -S " + quoted(fs::path(C3RT_SOURCE_DIRECTORY) / "examples" / example) +
            " -B " + quoted(built) + flags);
    succeed(cmake + " --build " + quoted(built));
    succeed(quoted(built / example) + " --help");
  }

  std::string plain;
  for (const std::string& one : consumers) {
    CAPTURE(one);
    if (!can_run(one)) {
      WARN("this machine cannot run " << one);
      continue;
    }
    const c3rt::support::Outcome answer =
        c3rt::support::outcome_of(quoted(consumer / ("consumer_" + one)));
    INFO(answer.output);
    REQUIRE(answer.status == 0);
    if (plain.empty()) plain = answer.output;
    CHECK(answer.output == plain);
  }
  CHECK(std::stod(plain) ==
        Approx(golden_u_0("cartpole_02_paper_G_I_MIQP")).epsilon(1e-5).margin(0.0));

  // no name of Eigen's, of the standard library's or of OSQP's is left to be merged with the
  // caller's
  for (const char* room : {"lcs", "c3", "horizon", "model", "example"}) {
    const std::string archive = std::string("libc3rt_") + room + ".a";
    fs::path found;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(prefix)) {
      if (entry.path().filename() == archive) found = entry.path();
    }
    const c3rt::support::Outcome names = c3rt::support::outcome_of(
        "nm --defined-only --extern-only --format=posix " + quoted(found));
    REQUIRE(names.status == 0);
    std::istringstream lines(names.output);
    int ours = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.empty() || line.back() == ':') continue;
      INFO(archive << ": " << line);
      CHECK(line.find("4c3rt") != std::string::npos);
      CHECK(line.find(" T ") != std::string::npos);
      ++ours;
    }
    CHECK(ours > 0);
  }

  for (const auto& [target, message] : std::vector<std::pair<std::string, std::string>>{
           {"row_major", "undefine EIGEN_DEFAULT_TO_ROW_MAJOR"},
           {"debug_vector", "undefine _GLIBCXX_DEBUG"},
           {"index", "undefine EIGEN_DEFAULT_DENSE_INDEX_TYPE"}}) {
    const c3rt::support::Outcome refused = build("refused_" + target);
    CHECK(refused.status != 0);
    CHECK_THAT(refused.output, Catch::Contains("c3rt: ") && Catch::Contains(message));
  }
}

TEST_CASE("package: a door to a robot builds outside of the project") {
  const fs::path build_tree(C3RT_BINARY_DIRECTORY), scratch = build_tree / "package_door_test";
  const fs::path prefix = scratch / "prefix", door = scratch / "examples/real_robot";
  fs::remove_all(scratch);
  const std::string cmake = std::string("'") + C3RT_CMAKE + "'";
  for (const std::string component : {"library", "door"}) {
    succeed(cmake + " --install " + quoted(build_tree) + " --component " + component +
            " --prefix " + quoted(prefix));
  }
  // where no source of ours can stand in for a header that the package lacks
  fs::create_directories(door);
  fs::copy(fs::path(C3RT_SOURCE_DIRECTORY) / "examples/real_robot", door);
  succeed(cmake + " -S " + quoted(door) + " -B " + quoted(scratch / "build") +
          " -DCMAKE_PREFIX_PATH=" + quoted(prefix) + " " + C3RT_CONSUMER_FLAGS);
  succeed(cmake + " --build " + quoted(scratch / "build"));
  const c3rt::support::Outcome answer = c3rt::support::outcome_of(
      quoted(scratch / "build/panda_plant") +
      " '" C3RT_SOURCE_DIRECTORY "/config/scenarios/circle_slow.yaml' --robot=172.16.0.2");
  CHECK(answer.status == 2);
  CHECK_THAT(answer.output, Catch::Contains("without libfranka"));
}
