// A secure service as a person starts it, and who must stay outside.
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "cli/keys/crypto.hpp"
#include "cli/keys/keystore.hpp"
#include "cli/paths.hpp"
#include "idl/security.hpp"
#include "tests/cli/folder.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/outcome.hpp"

namespace {

namespace fs = std::filesystem;
using namespace c3rt;
using namespace c3rt::test;
using Catch::Contains;

const std::string kConfig = C3RT_SOURCE_DIRECTORY "/config/dds/";

// no other test has these
std::string domain() { return std::to_string(200 + getpid() % 10); }

/// A folder with keys, and commands that use them.
class Host {
 public:
  Host() {
    fs::create_directories(path() / "runtime");
    const support::Outcome made = c3rt("keys init --days 2");
    INFO(made.output);
    REQUIRE(made.status == 0);
  }
  ~Host() { c3rt("down --domain " + domain()); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;
  fs::path path() const { return folder_.path(); }
  fs::path keys() const { return path() / "keys"; }
  support::Outcome c3rt(const std::string& arguments) const {
    return support::outcome_of("cd '" + path().string() + "' && XDG_RUNTIME_DIR='" +
                               (path() / "runtime").string() + "' C3RT_KEYS='" + keys().string() +
                               "' '" C3RT_BINARY_DIRECTORY "/bin/c3rt' " + arguments);
  }

 private:
  cli::Folder folder_;
};

/// What somebody with these keys and this profile comes to, by topic; reads and writes -1 where
/// its own rights do not let it try.
class Party {
 public:
  struct Came {
    long read, met;
  };
  Party(const Host& host, const std::string& name, const fs::path& keys, const std::string& profile,
        const std::string& identity, const std::vector<std::string>& until = {})
      : output_(host.path() / (name + ".txt")),
        process_(command(keys, profile, identity, until), output_.string()) {}
  /// Of one that nothing comes to.
  std::map<std::string, Came> stop() {
    process_.signal(SIGTERM);
    return end();
  }
  std::map<std::string, Came> end() {
    const int status = process_.wait();
    const std::string said = cli::read_text(output_);
    INFO(said);
    REQUIRE(status == 0);
    std::map<std::string, Came> all;
    std::istringstream lines(said);
    const auto number = [](const std::string& word) { return word == "-" ? -1 : std::stol(word); };
    // Cyclone's own words about whom it does not trust stand among them
    const std::regex expected("(\\S+) (-|[0-9]+) (-|[0-9]+)");
    std::smatch words;
    for (std::string line; std::getline(lines, line);) {
      if (std::regex_match(line, words, expected))
        all[words[1]] = {number(words[2]), number(words[3])};
    }
    REQUIRE(all.size() == wire::table::kTopics.size());
    return all;
  }

 private:
  static std::vector<std::string> command(const fs::path& keys, const std::string& profile,
                                          const std::string& identity,
                                          const std::vector<std::string>& until) {
    std::vector<std::string> words{"/usr/bin/env",    "C3RT_KEYS=" + keys.string(),
                                   C3RT_SECURE_PARTY, domain(),
                                   profile,           identity};
    words.insert(words.end(), until.begin(), until.end());
    return words;
  }
  fs::path output_;
  ChildProcess process_;
};

/// A keystore in which vision has made itself the impedance controller, by an authority of its own.
void forge(const fs::path& real, const fs::path& folder) {
  fs::create_directories(folder / "vision");
  fs::copy_file(real / "ca.crt", folder / "ca.crt");
  for (const char* file : {"identity.crt", "identity.key"})
    fs::copy_file(real / "vision" / file, folder / "vision" / file);
  using namespace cli::keys;
  const Period period = Certificate::read(cli::read_text(folder / "vision/identity.crt")).period();
  const Key key = Key::make();
  const Certificate authority = Certificate::make_authority("vision's own", key, period);
  std::ofstream(folder / "own.crt") << authority.pem();
  std::ofstream(folder / "governance.p7s") << sign(wire::governance(), authority, key);
  const wire::Identity everything{"vision", wire::party::kAll};
  std::ofstream(folder / "vision" / "permissions.p7s") << sign(
      wire::permissions(everything, "CN=vision", "2020-01-01T00:00:00", "2100-01-01T00:00:00"),
      authority, key);
}

}  // namespace

TEST_CASE(
    "secure: a service runs among those with keys; strangers, and rights that nobody gave, "
    "read and write nothing") {
  const Host host, other;
  const fs::path forged = host.path() / "forged";
  forge(host.keys(), forged);
  std::string profile = cli::read_text(kConfig + "secure.xml");
  const std::string authority = "<PermissionsCA>file:${C3RT_KEYS}/ca.crt";
  REQUIRE(profile.find(authority) != std::string::npos);
  profile.replace(profile.find(authority), authority.size(),
                  "<PermissionsCA>file:${C3RT_KEYS}/own.crt");
  std::ofstream(host.path() / "forged.xml") << profile;

  const support::Outcome up =
      host.c3rt("up circle_slow --clock lockstep --profile secure --domain " + domain());
  INFO(up.output);
  REQUIRE(up.status == 0);
  const std::string secure = kConfig + "secure.xml";
  Party plain(host, "plain", host.keys(), kConfig + "loopback.xml", "client");
  Party foreign(host, "foreign", other.keys(), secure, "impedance");
  Party self_made(host, "self_made", forged, (host.path() / "forged.xml").string(), "vision");
  Party vision(host, "vision", host.keys(), secure, "vision", {"robot/state", "object/estimate"});
  Party client(host, "client", host.keys(), secure, "client",
               {"robot/state", "robot/command", "task/target"});

  // those inside first: meanwhile the others have had as much time
  const auto seen = vision.end();
  const auto known = client.end();
  for (Party* outside : {&plain, &foreign, &self_made}) {
    const auto tried = outside->stop();
    CHECK(tried.at("robot/command").met == 0);  // its own rights let it try
    for (const auto& [topic, came] : tried) {
      INFO(topic);
      CHECK(came.read <= 0);
      CHECK(came.met <= 0);
    }
  }
  CHECK(seen.at("robot/command").met == -1);
  CHECK(seen.at("robot/command").read == -1);
  CHECK(seen.at("plan").met == -1);
  CHECK(seen.at("robot/state").read > 0);
  CHECK(seen.at("object/estimate").met > 0);
  CHECK(known.at("robot/state").read > 0);
  CHECK(known.at("robot/command").read > 0);
  CHECK(known.at("robot/command").met == -1);
  CHECK(known.at("task/target").met > 0);

  const support::Outcome target = host.c3rt("target hold --domain " + domain());
  CHECK(target.status == 0);
  const support::Outcome status = host.c3rt("status --domain " + domain());
  INFO(status.output);
  CHECK(status.status == 0);
  CHECK(host.c3rt("down --domain " + domain()).status == 0);
}

TEST_CASE("secure: a run gives the same bits as without keys") {
  const Host host;
  const auto hash = [&](const std::string& options) {
    const support::Outcome run =
        host.c3rt("run circle_slow --duration 0.5 --no-pictures --out run " + options);
    INFO(run.output);
    REQUIRE(run.status == 1);  // no circle takes half a second
    const auto report = nlohmann::json::parse(cli::read_text(host.path() / "run" / "report.json"));
    return report.at("log_hash").get<std::string>();
  };
  const std::string secure = hash("--clock lockstep --profile secure --domain any");
  CHECK(secure == hash("--in-process"));
}

TEST_CASE("secure: bad keys are told by name before anything starts") {
  const Host host;
  fs::remove(host.keys() / "vision" / "identity.key");
  for (const std::string command :
       {"run circle_slow --profile secure --domain any", "up circle_slow --profile secure",
        "latency circle_slow --profile secure --duration 20",
        "soak circle_slow --profile secure"}) {
    INFO(command);
    const support::Outcome refused = host.c3rt(command);
    CHECK(refused.status == 2);
    CHECK_THAT(refused.output,
               Contains("vision/identity.key is missing") && Contains("c3rt keys init --force"));
  }
  CHECK_FALSE(fs::exists(host.path() / "out"));
  const support::Outcome doctor = host.c3rt("doctor --profile secure --domain " + domain());
  CHECK(doctor.status == 1);
  CHECK_THAT(doctor.output, Contains("vision/identity.key is missing"));
  CHECK(host.c3rt("keys check").status == 1);
  CHECK(host.c3rt("keys check client").status == 0);
}
