// c3rt lcs inspect as a person meets it.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/folder.hpp"
#include "tests/support/outcome.hpp"

namespace {

using namespace c3rt::cli;
using c3rt::support::Outcome;
using Catch::Contains;
namespace fs = std::filesystem;

const std::string kObjects = C3RT_SOURCE_DIRECTORY "/config/objects/";
const std::string kT = "'" + kObjects + "t.xml'";

Outcome run(const std::string& arguments) {
  return c3rt::support::outcome_of("'" C3RT_BINARY_DIRECTORY "/bin/c3rt' " + arguments);
}

}  // namespace

TEST_CASE("inspect: bodies, contacts, sizes, conditioning and errors of the shipped T") {
  const Outcome outcome = run("lcs inspect " + kT);
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output,
             Contains("t: mass 0.56 kg") && Contains("160 x 160 x 40 mm") &&
                 Contains("box of 160 x 40 x 40 mm at 0 34.29 0 mm") &&
                 Contains("end_effector_object (end effector and t): gap 10 mm, normal -") &&
                 Contains("object_table (t and table): gap 0 mm, normal 0.000 0.000 1.000") &&
                 Contains("n_x 18, n_u 3, n_lambda 20: anitescu, 5 contacts with 4 edges") &&
                 Contains("symmetric, positive semidefinite") && Contains("at rest") &&
                 Contains("34.29 mm from the origin of body"));
}

TEST_CASE("inspect: contacts, contact model and step are as asked for") {
  const Outcome chosen =
      run("lcs inspect " + kT + " " + kT + " --pairs object_table " +
          "object_object --contact-model stewart_trinkle --step 0.02 " + "--support-points 3");
  CHECK(chosen.status == 0);
  CHECK_THAT(chosen.output,
             Contains("object_object (t and t): gap 50 mm") &&
                 Contains("n_x 30, n_u 3, n_lambda 42: stewart_trinkle, 7 contacts") &&
                 Contains("step 0.02 s") && !Contains("end_effector_object"));
  const Outcome inside = run("lcs inspect " + kT + " --effector 0 0 0");
  CHECK(inside.status == 0);
  CHECK_THAT(inside.output, Contains("end effector and t overlap by"));
}

TEST_CASE("inspect: what a person should mind is told") {
  const Folder folder;
  const fs::path file = folder.path() / "thing.xml";
  std::ofstream(file) << "<mujoco><worldbody><body name=\"thing\"><freejoint/>"
                         "<geom type=\"box\" size=\"50 30 20\" euler=\"0 0 45\"/>"
                         "<geom type=\"sphere\" size=\"40\"/></body></worldbody></mujoco>";
  const Outcome outcome = run("lcs inspect '" + file.string() + "'");
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output, Contains("millimetres") && Contains("angles are degrees") &&
                                 Contains("no mass and no density") && Contains("weighed twice"));
}

TEST_CASE("inspect: the LCS as a problem is one that c3rt solve takes") {
  const Folder folder;
  const std::string problem = "'" + (folder.path() / "problem.json").string() + "'";
  const std::string result = (folder.path() / "result.json").string();
  const Outcome written = run("lcs inspect " + kT + " --out " + problem);
  REQUIRE(written.status == 0);
  const Outcome solved = run("solve " + problem + " --out '" + result + "'");
  CAPTURE(solved.output);
  REQUIRE(solved.status == 0);
  const auto json = nlohmann::json::parse(std::ifstream(result));
  CHECK(json["status"] == "ok");
  CHECK(json["x"][0].size() == 18);
  // it begins to move towards the goal
  CHECK(json["x"][10][3].get<double>() > json["x"][0][3].get<double>() + 0.01);
}

TEST_CASE("inspect: a model that cannot be planned with is a usage error that names it") {
  const Folder folder;
  const fs::path file = folder.path() / "door.xml";
  std::ofstream(file) << "<mujoco><worldbody><body name=\"door\"><joint name=\"pin\"/>"
                         "<geom size=\"0.1\"/></body></worldbody></mujoco>";
  const Outcome door = run("lcs inspect '" + file.string() + "'");
  CHECK(door.status == 2);
  CHECK_THAT(door.output, Contains("door.xml: expected a rigid object") && Contains("\"pin\""));
  CHECK(run("lcs inspect /nowhere.xml").status == 2);
  CHECK(run("lcs inspect").status == 2);
  CHECK(run("lcs").status == 2);
  CHECK_THAT(run("lcs inspect " + kT + " --pairs object_tabel").output,
             Contains("did you mean \"object_table\"?"));
  const Outcome alone = run("lcs inspect " + kT + " --pairs object_object");
  CHECK(alone.status == 2);
  CHECK_THAT(alone.output, Contains("of one object alone"));
  const Outcome nowhere = run("lcs inspect " + kT + " --out /no/such/folder/problem.json");
  CHECK(nowhere.status != 0);
}

TEST_CASE("inspect: a mechanism's coordinates, motors, bodies, contacts and errors") {
  const std::string pusher = "'" C3RT_SOURCE_DIRECTORY "/examples/pusher/pusher.xml'";
  const Outcome outcome = run("lcs inspect " + pusher);
  CAPTURE(outcome.output);
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.output,
             Contains("fork_x: slide, 0 mm") && Contains("disc_x: free body, 100 mm") &&
                 Contains("force_x: -20 to 20 N") && Contains("disc: mass 0.3 kg") &&
                 Contains("left and rim: gap 26.98 mm") && Contains("disc and floor: gap 0 mm") &&
                 Contains("n_x 16, n_u 2, n_lambda 28: anitescu, 7 contacts with 4 edges") &&
                 Contains("symmetric, positive semidefinite") && Contains("at rest"));
  const Outcome chosen =
      run("lcs inspect " + pusher + " --pairs fork,disc,closest=1,friction=0.3 disc,world " +
          "--contact-model stewart_trinkle --directions 1 --across 0 0 1 --support-points 3");
  CAPTURE(chosen.output);
  CHECK(chosen.status == 0);
  CHECK_THAT(chosen.output, Contains("left and rim: gap 26.98 mm") && Contains("friction 0.3") &&
                                Contains("n_lambda 16: stewart_trinkle, 4 contacts with 2 edges"));
}

TEST_CASE("inspect: the LCS of a mechanism is a problem that c3rt solve takes, with its bounds") {
  const Folder folder;
  const std::string problem = (folder.path() / "problem.json").string();
  const std::string result = (folder.path() / "result.json").string();
  const Outcome written = run("lcs inspect '" C3RT_SOURCE_DIRECTORY
                              "/examples/pusher/pusher.xml' "
                              "--pairs fork,disc disc,floor --out '" +
                              problem + "'");
  CAPTURE(written.output);
  REQUIRE(written.status == 0);
  CHECK_THAT(written.output, Contains("disc_x by 0.1"));
  const Outcome solved = run("solve '" + problem + "' --out '" + result + "'");
  CAPTURE(solved.output);
  REQUIRE(solved.status == 0);
  const auto json = nlohmann::json::parse(std::ifstream(result));
  CHECK(json["status"] == "ok");
  CHECK(json["x"][0].size() == 16);
  CHECK(json["x"][10][2].get<double>() > json["x"][0][2].get<double>() + 0.01);
  for (const auto& u : json["u"]) CHECK(std::abs(u[0].get<double>()) <= 20.0 + 1e-6);
}

TEST_CASE("inspect: of a mechanism what does not fit is named") {
  const std::string pusher = "'" C3RT_SOURCE_DIRECTORY "/examples/pusher/pusher.xml'";
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    const Outcome outcome = run("lcs inspect " + arguments);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.output, Contains(words));
  };
  refused(pusher + " --pairs fork,disk", "got \"disk\"");
  refused(pusher + " --pairs fork,disc,nearest=1", "expected FIRST,SECOND");
  refused(pusher + " --pairs fork,disc,friction=-1", "expected FIRST,SECOND");
  refused(pusher + " --pairs object_table", "expected FIRST,SECOND");
  refused(pusher + " " + kT, "expected one file");
  refused(pusher + " --effector 0 0 0", "--effector: expected objects alone");
  refused(kT + " --pairs tip,disc", "expected pairs of a model without motors");
  refused(kT + " --directions 2", "expected a model with motors");
}
