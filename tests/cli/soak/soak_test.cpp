// c3rt soak, as a person calls it, in simulated time.
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/long_run.hpp"

using namespace c3rt;
using nlohmann::json;

namespace {

struct Soaked : cli::LongRun {
  std::vector<std::string> passes;  // lines of passes.csv
};

Soaked soak(const std::vector<std::string>& arguments) {
  const cli::Folder folder;
  Soaked result{cli::long_run("soak", arguments, folder), {}};
  std::ifstream passes(folder.path() / "out" / "passes.csv");
  std::string line;
  for (std::getline(passes, line); std::getline(passes, line);) result.passes.push_back(line);
  return result;
}

}  // namespace

TEST_CASE("soak: a run that keeps everything ends with 0") {
  const Soaked soaked = soak({"circle_slow", "--in-process", "--duration", "8s"});
  CAPTURE(soaked.said);
  REQUIRE(soaked.report.is_object());
  CHECK(soaked.status == 0);
  CHECK(soaked.report.at("result") == "passed");
  CHECK(soaked.report.at("violations").at("count") == 0);
  CHECK(soaked.report.at("soaked_s").get<double>() == Approx(8.0).margin(0.1));
  CHECK(soaked.report.at("samples").get<int>() > 16'000);
  CHECK(soaked.report.at("processes").at(0).at("name") == "c3rt");
}

TEST_CASE("soak: each pass has the next seed, and what it violates is shown again by its command") {
  // no circle is finished in that time, which the criteria want
  const Soaked soaked = soak({"circle_slow", "--in-process", "--seed", "5", "--passes", "2",
                              "--set", "task.duration_s=3"});
  CAPTURE(soaked.said);
  REQUIRE(soaked.report.is_object());
  CHECK(soaked.status == 1);
  CHECK(soaked.report.at("passes").at("whole") == 2);
  CHECK(soaked.report.at("passes").at("met") == 0);
  for (const auto& [name, count] : soaked.report.at("violations").at("by_name").items())
    CHECK(name == "criterion");
  REQUIRE(soaked.passes.size() == 2);
  CHECK(soaked.passes[0].find("1,5,") == 0);
  CHECK(soaked.passes[1].find("2,6,") == 0);
  const auto hash = [](const std::string& pass) { return pass.substr(pass.rfind(',')); };
  CHECK(hash(soaked.passes[0]) != hash(soaked.passes[1]));

  const std::string again = soaked.report.at("reproduce").at(1);
  CHECK(soaked.said.find(again) != std::string::npos);
  std::vector<std::string> words;
  std::istringstream stream(again.substr(std::string("c3rt soak ").size()));
  for (std::string word; stream >> word;) words.push_back(word);
  const Soaked second = soak(words);
  CHECK(second.status == 1);
  REQUIRE(second.passes.size() == 1);
  CHECK(hash(second.passes[0]) == hash(soaked.passes[1]));
}

TEST_CASE("soak: Ctrl-C ends it with the report of what was done") {
  const cli::Folder folder;
  const auto [status, report, said] =
      cli::long_run("soak", {"circle_slow", "--in-process", "--duration", "24h"}, folder, true);
  CHECK(status == 1);
  REQUIRE(report.is_object());
  CHECK(report.at("result") == "interrupted");
  CHECK(report.at("passes").at("begun") == 1);
  CHECK(report.at("violations").at("count") == 0);
}

TEST_CASE("soak: what cannot be soaked is a usage error") {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"circle_slow", "--duration", "0"},
                                             {"circle_slow", "--duration", "soon"},
                                             {"circle_slow", "--passes", "0"},
                                             {"circle_slow", "--in-process", "--domain", "3"},
                                             {"no_such_scenario"},
                                             {"push_t"}}) {  // in realtime nobody puts the T back
    CAPTURE(arguments);
    CHECK(soak(arguments).status == 2);
  }
}
