#include "cli/keys/keystore.hpp"

#include <fstream>

#include <catch2/catch.hpp>
#include <sys/stat.h>

#include "cli/keys/crypto.hpp"
#include "idl/security.hpp"
#include "tests/cli/folder.hpp"

using namespace c3rt;
using namespace c3rt::cli;
using namespace c3rt::cli::keys;

namespace {
namespace fs = std::filesystem;

constexpr std::time_t kNow = 1'790'000'000;  // 2026-09-21 14:13:20 UTC
constexpr std::time_t kDay = 86400;
constexpr int kDays = 10;

/// A keystore of ten days from kNow on.
class Store {
 public:
  Store() { make(path(), kDays, false, kNow); }
  fs::path path() const { return folder_.path() / "keys"; }
  fs::path folder() const { return folder_.path(); }
  Findings look(std::time_t now = kNow) const { return check(path(), identity_names(), now); }
  /// All that is wrong and all advice, in one text.
  std::string said(std::time_t now = kNow) const {
    std::string all;
    for (const Complaint& complaint : look(now).problems)
      all += complaint.text + "\n" + complaint.advice + "\n";
    return all;
  }

 private:
  Folder folder_;
};

mode_t mode_of(const fs::path& file) {
  struct stat status {};
  REQUIRE(stat(file.c_str(), &status) == 0);
  return status.st_mode & 07777;
}

using Catch::Matchers::Contains;

}  // namespace

TEST_CASE("keystore: what was made is good for all, from an hour ago until its last day") {
  const Store store;
  CHECK(store.said() == "");
  CHECK(store.said(kNow - kClockSkew + 1) == "");
  CHECK(store.said(kNow + kDays * kDay - 1) == "");
  CHECK(store.look().expires == kNow + kDays * kDay);
}

TEST_CASE("keystore: only its owner reads private keys, and nothing else is left") {
  const Store store;
  CHECK(mode_of(store.path() / "ca.key") == 0600);
  for (const std::string& name : identity_names())
    CHECK(mode_of(store.path() / name / "identity.key") == 0600);
  int beside = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(store.folder())) ++beside;
  CHECK(beside == 1);
}

TEST_CASE("keystore: expired keys are named with the dates and what to do") {
  const Store store;
  const std::string said = store.said(kNow + kDays * kDay);
  CHECK_THAT(said, Contains("the certificate of planner expired on 2026-10-01 14:13:20 UTC"));
  CHECK_THAT(said, Contains("the authority's certificate expired"));
  CHECK_THAT(said, Contains("c3rt keys init --force"));
}

TEST_CASE("keystore: keys of a host whose clock is ahead are told apart from expired ones") {
  const Store store;
  const std::string said = store.said(kNow - 2 * kClockSkew);
  CHECK_THAT(said, Contains("the certificate of vision is not valid before 2026-09-21 13:13:20 "
                            "UTC, and this host's clock says 2026-09-21 12:13:20 UTC"));
  CHECK_THAT(said, Contains("timedatectl"));
}

TEST_CASE("keystore: what is missing is named, of those that are asked for alone") {
  const Store store;
  fs::remove(store.path() / "planner" / "identity.key");
  fs::remove_all(store.path() / "vision");
  CHECK_THAT(store.said(), Contains("planner/identity.key is missing"));
  CHECK_THAT(store.said(), Contains("vision/identity.crt is missing"));
  CHECK(check(store.path(), {"client", "plant"}, kNow).problems.empty());
  const Findings nothing = check(store.folder() / "none", {"client"}, kNow);
  REQUIRE(nothing.problems.size() == 1);
  CHECK_THAT(nothing.problems[0].advice, Contains("c3rt keys init --out"));
}

TEST_CASE("keystore: the authority's key may lie elsewhere") {
  const Store store;
  fs::remove(store.path() / "ca.key");
  CHECK(store.said() == "");
}

TEST_CASE("keystore: keys of another keystore are foreign") {
  const Store store, other;
  fs::remove_all(store.path() / "vision");
  fs::copy(other.path() / "vision", store.path() / "vision");
  const std::string said = store.said();
  CHECK_THAT(said, Contains("the certificate of vision is foreign"));
  CHECK_THAT(said, !Contains("planner"));
}

TEST_CASE("keystore: one identity in the folder of another is told") {
  const Store store;
  fs::remove_all(store.path() / "impedance");
  fs::copy(store.path() / "vision", store.path() / "impedance");
  CHECK_THAT(store.said(), Contains("the certificate of impedance is another one's: CN=vision"));
}

TEST_CASE("keystore: rights that the authority did not sign, or of other topics, are told") {
  const Store store, other;
  const auto swap = [&](const std::string& text) {
    std::ofstream(store.path() / "vision" / "permissions.p7s") << text;
  };
  const Key key = Key::read(read_text(store.path() / "ca.key"));
  const Certificate authority = Certificate::read(read_text(store.path() / "ca.crt"));
  swap(sign("<dds/>", authority, key));
  CHECK_THAT(store.said(), Contains("vision/permissions.p7s is not what the topics of this version "
                                    "need"));
  swap(sign("<dds/>", Certificate::read(read_text(other.path() / "ca.crt")),
            Key::read(read_text(other.path() / "ca.key"))));
  CHECK_THAT(store.said(), Contains("vision/permissions.p7s is not signed by this authority"));
  swap("nonsense");
  CHECK_THAT(store.said(), Contains("not a document signed with S/MIME"));
}

TEST_CASE("keystore: a key that others may read is told with the command that mends it") {
  const Store store;
  const fs::path key = store.path() / "plant" / "identity.key";
  chmod(key.c_str(), 0644);
  CHECK_THAT(store.said(), Contains("is open to others (mode 0644)"));
  CHECK_THAT(store.said(), Contains("chmod 600 " + key.string()));
}

TEST_CASE("keystore: a key of another pair and a broken file are told") {
  const Store store;
  std::ofstream(store.path() / "plant" / "identity.key")
      << read_text(store.path() / "vision" / "identity.key");
  CHECK_THAT(store.said(), Contains("the key of plant does not belong to its certificate"));
  std::ofstream(store.path() / "plant" / "identity.crt") << "broken";
  CHECK_THAT(store.said(), Contains("not a certificate in PEM"));
}

TEST_CASE("keystore: keys are replaced only when that is asked for, and nothing else ever is") {
  const Store store;
  const std::string before = read_text(store.path() / "ca.crt");
  CHECK_THROWS_AS(make(store.path(), kDays, false, kNow), UsageError);
  CHECK(read_text(store.path() / "ca.crt") == before);
  make(store.path(), kDays, true, kNow);
  CHECK(read_text(store.path() / "ca.crt") != before);
  CHECK(store.said() == "");
  std::ofstream(store.path() / "thesis.txt") << "years of work";
  CHECK_THROWS_AS(make(store.path(), kDays, true, kNow), UsageError);
  CHECK(fs::exists(store.path() / "thesis.txt"));
  CHECK_THROWS_AS(make(store.folder(), kDays, true, kNow), UsageError);
}
