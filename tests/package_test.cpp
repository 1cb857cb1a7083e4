// find_package(c3rt) as a stranger meets it: the library is installed into an empty prefix, and a
// project outside of this one (tests/package) is configured against it, built and run.
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

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

}  // namespace

TEST_CASE("a project that has only the installed package and Eigen builds and solves") {
  const fs::path build(C3RT_BINARY_DIRECTORY), scratch = build / "package";
  const fs::path prefix = scratch / "prefix", consumer = scratch / "consumer";
  fs::remove_all(scratch);
  const std::string cmake = std::string("'") + C3RT_CMAKE + "'";

  succeed(cmake + " --install " + quoted(build) + " --component library --prefix " +
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
  succeed(cmake + " -S " + quoted(fs::path(C3RT_SOURCE_DIRECTORY) / "tests/package") + " -B " +
          quoted(consumer) + " -DCMAKE_PREFIX_PATH=" + quoted(prefix) + " " + C3RT_CONSUMER_FLAGS);
  succeed(cmake + " --build " + quoted(consumer));

  const c3rt::support::Outcome answer = c3rt::support::outcome_of(quoted(consumer / "consumer"));
  INFO(answer.output);
  REQUIRE(answer.status == 0);
  CHECK(std::stod(answer.output) ==
        Approx(golden_u_0("cartpole_02_paper_G_I_MIQP")).epsilon(1e-5).margin(0.0));
}
