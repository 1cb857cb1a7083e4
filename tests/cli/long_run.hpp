#pragma once
// c3rt soak and c3rt chaos, as a person calls them.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cli/paths.hpp"
#include "tests/cli/eventually.hpp"
#include "tests/cli/folder.hpp"
#include "tests/support/child_process.hpp"

namespace c3rt::cli {

/// What is left of one.
struct LongRun {
  int status;
  nlohmann::json report;  // NAME.json; null where there is none
  std::string said;
};

/// The words of `c3rt NAME ARGUMENTS…`, whose results go to `out`.
inline std::vector<std::string> long_command(const std::string& name,
                                             const std::vector<std::string>& arguments,
                                             const std::filesystem::path& out) {
  std::vector<std::string> words{test::program("c3rt"), name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.insert(words.end(), {"--no-pictures", "--out", out.string()});
  return words;
}

/// Runs it to its end, or with `ctrl_c` until it has begun a pass and is told to end.
inline LongRun long_run(const std::string& name, const std::vector<std::string>& arguments,
                        const Folder& folder, bool ctrl_c = false) {
  const auto out = folder.path() / "out", log = folder.path() / "said.txt";
  test::ChildProcess child(long_command(name, arguments, out), log.string());
  if (ctrl_c) {
    REQUIRE(eventually([&] { return std::filesystem::exists(out / "processes.csv"); }));
    child.signal(SIGINT);
  }
  LongRun run{child.wait(), {}, read_text(log)};
  std::ifstream file(out / (name + ".json"));
  if (file) file >> run.report;
  return run;
}

}  // namespace c3rt::cli
