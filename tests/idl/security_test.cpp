#include "idl/security.hpp"

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::wire;
using namespace c3rt::wire::test;

namespace {

using Topics = std::set<std::string>;

std::string text_of(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::string permissions_of(const std::string& name) {
  for (const Identity& identity : kIdentities) {
    if (name == identity.name)
      return permissions(identity, "CN=" + name, "2026-01-01T00:00:00", "2027-01-01T00:00:00");
  }
  return "";
}

/// The topics of all <publish> or <subscribe> of a permission.
Topics allowed(const std::string& permission, const std::string& verb) {
  Topics topics;
  const std::regex block("<" + verb + ">([^]*?)</" + verb + ">"), topic("<topic>([^<]*)</topic>");
  for (std::sregex_iterator at(permission.begin(), permission.end(), block), end; at != end; ++at) {
    const std::string inside = (*at)[1];
    for (std::sregex_iterator one(inside.begin(), inside.end(), topic), last; one != last; ++one)
      topics.insert((*one)[1]);
  }
  return topics;
}

}  // namespace

TEST_CASE("security: each identity writes what the contract gives it and nothing else") {
  const Topics of_every{"sim/done", "service/status", "service/reply"};
  const std::map<std::string, Topics> own{
      {"plant", {"robot/state", "robot/contact", "sim/scene", "sim/tick", "latency/*"}},
      {"impedance", {"robot/command", "robot/motion", "latency/*"}},
      {"planner", {"plan", "planner/debug"}},
      {"vision", {"object/estimate", "object/detection"}},
      {"client",
       {"task/target", "service/request", "fault/inject", "robot/order", "planner/weights"}}};
  for (const auto& [name, topics] : own) {
    INFO(name);
    Topics expected = topics;
    expected.insert(of_every.begin(), of_every.end());
    if (name == "client") expected.erase("service/status");
    CHECK(allowed(permissions_of(name), "publish") == expected);
  }
}

TEST_CASE("security: vision neither writes the torque nor gets the key to read it") {
  const std::string vision = permissions_of("vision");
  CHECK(allowed(vision, "publish").count("robot/command") == 0);
  CHECK(allowed(vision, "subscribe").count("robot/command") == 0);
  CHECK(vision.find("<default>DENY</default>") != std::string::npos);
}

TEST_CASE("security: a client reads every topic") {
  Topics all;
  for (const Topic& topic : table::kTopics) all.insert(topic.name);
  CHECK(allowed(permissions_of("client"), "subscribe") == all);
}

TEST_CASE("security: a subject is written as XML") {
  const std::string text = permissions(kIdentities[0], "CN=<a&b>", "", "");
  CHECK(text.find("<subject_name>CN=&lt;a&amp;b&gt;</subject_name>") != std::string::npos);
}

TEST_CASE("security: Cyclone's three plugins lie in one folder") {
  for (const char* plugin : {"auth", "ac", "crypto"}) {
    INFO(plugin);
    CHECK(std::filesystem::exists(security_plugins() /
                                  ("libdds_security_" + std::string(plugin) + ".so")));
  }
}

TEST_CASE("security: a secure profile is its plain one and what names the keys") {
  const std::string folder = C3RT_SOURCE_DIRECTORY "/config/dds/";
  const std::regex note("<!--[^]*?-->"), security("<Security>[^]*</Security>"), space("\\s+");
  const auto plain = [&](const std::string& name) {
    std::string text = std::regex_replace(text_of(folder + name + ".xml"), note, "");
    text = std::regex_replace(text, security, "");
    return std::regex_replace(text, space, " ");
  };
  CHECK(std::regex_replace(without_keys(text_of(folder + "secure.xml")), space, " ") ==
        plain("loopback"));
  CHECK(plain("secure") == plain("loopback"));
  CHECK(plain("secure_lan") == plain("lan"));
  CHECK_FALSE(is_secure(text_of(folder + "loopback.xml")));
  CHECK_FALSE(is_secure("<Domain><!-- <Security> --></Domain> <!-- <Security>"));
  for (const char* name : {"secure.xml", "secure_lan.xml"}) {
    INFO(name);
    const std::string text = text_of(folder + name);
    CHECK(is_secure(text));
    const std::string filled =
        std::regex_replace(with_keys(text, "/there/a&b", "planner"), note, "");
    CHECK(filled.find("${") == std::string::npos);
    CHECK(filled.find("file:/there/a&amp;b/planner/identity.key") != std::string::npos);
  }
}

TEST_CASE("security: the keystore is where the environment says, else among one's settings") {
  setenv("C3RT_KEYS", "/there", 1);
  CHECK(keys_directory() == "/there");
  unsetenv("C3RT_KEYS");
  setenv("XDG_CONFIG_HOME", "/settings", 1);
  CHECK(keys_directory() == "/settings/c3rt/keys");
  unsetenv("XDG_CONFIG_HOME");
  setenv("HOME", "/home/somebody", 1);
  CHECK(keys_directory() == "/home/somebody/.config/c3rt/keys");
}
