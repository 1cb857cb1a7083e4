// docs/tutorial.md: a stranger types its commands one after the other in an empty folder.
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/cli/folder.hpp"
#include "tests/support/outcome.hpp"

using c3rt::support::Outcome;
using Catch::Contains;

namespace {

/// What stands between ```sh and ```.
std::vector<std::string> blocks_of(const std::string& page) {
  std::ifstream file(page);
  std::vector<std::string> blocks;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line == "```sh") {
      inside = true;
      blocks.emplace_back();
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      blocks.back() += line + "\n";
    }
  }
  return blocks;
}

}  // namespace

TEST_CASE("tutorial: each command works in its turn, and the arrow reaches its goal") {
  const c3rt::cli::Folder folder;
  const std::vector<std::string> blocks = blocks_of(C3RT_SOURCE_DIRECTORY "/docs/tutorial.md");
  REQUIRE(blocks.size() == 7);
  int passed = 0;
  for (const std::string& block : blocks) {
    CAPTURE(block);
    std::ofstream(folder.path() / "block.sh") << block;
    const Outcome outcome = c3rt::support::outcome_of("cd '" + folder.path().string() +
                                                      "' && PATH='" C3RT_BINARY_DIRECTORY
                                                      "/bin':\"$PATH\" bash -e block.sh");
    CAPTURE(outcome.output);
    CHECK(outcome.status == 0);
    if (outcome.output.find("): passed") != std::string::npos) ++passed;
  }
  CHECK(passed == 2);
}
