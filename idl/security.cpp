#include "idl/security.hpp"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include <dds/dds.h>
#include <dlfcn.h>

#include "idl/dds.hpp"
#include "idl/raw_ping.hpp"

namespace c3rt::wire {
namespace fs = std::filesystem;
namespace {

constexpr int kLastDomain = 230;
constexpr const char* kPlugin = "libdds_security_auth.so";

std::string domains() {
  return "<domains><id_range><min>0</min><max>" + std::to_string(kLastDomain) +
         "</max></id_range></domains>\n";
}

/// `verb` publish or subscribe. The addressed topics are in partitions, all others in none.
std::string criteria(const char* verb, const std::vector<std::string>& topics,
                     const char* partition) {
  if (topics.empty()) return "";
  std::string text = std::string("        <") + verb + ">\n          <topics>";
  for (const std::string& topic : topics) text += "<topic>" + topic + "</topic>";
  text += "</topics>\n";
  if (*partition != '\0')
    text += std::string("          <partitions><partition>") + partition +
            "</partition></partitions>\n";
  return text + "        </" + verb + ">\n";
}

std::string allowed(const char* verb, Parties party, Parties Topic::*who) {
  std::vector<std::string> plain, addressed;
  for (const Topic& topic : table::kTopics) {
    if ((topic.*who & party) == 0) continue;
    (topic.trait == Trait::kAddressed ? addressed : plain).emplace_back(topic.name);
  }
  // c3rt latency measures with the keys of both ends of the servo's loop
  if ((party & (party::kPlant | party::kImpedance)) != 0) plain.emplace_back(kPingTopics);
  return criteria(verb, plain, "") + criteria(verb, addressed, "*");
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

/// Without each part from `begin` to the next `end`.
std::string without(std::string text, const std::string& begin, const std::string& end) {
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    const std::size_t last = text.find(end, at);
    text.erase(at, last == std::string::npos ? last : last + end.size() - at);
  }
  return text;
}

/// As XML writes it.
std::string escaped(std::string text) {
  replace_all(text, "&", "&amp;");
  replace_all(text, "<", "&lt;");
  replace_all(text, ">", "&gt;");
  return text;
}

}  // namespace

std::string governance() {
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      )" +
         domains() +
         R"(      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";
}

std::string permissions(const Identity& identity, const std::string& subject,
                        const std::string& not_before, const std::string& not_after) {
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name=")" +
         std::string(identity.name) + "\">\n      <subject_name>" + escaped(subject) +
         "</subject_name>\n      <validity><not_before>" + not_before + "</not_before><not_after>" +
         not_after + "</not_after></validity>\n      <allow_rule>\n        " + domains() +
         allowed("publish", identity.party, &Topic::writers) +
         allowed("subscribe", identity.party, &Topic::readers) +
         R"(      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
)";
}

bool is_secure(const std::string& profile) {
  // what stands in a comment demands nothing
  const std::string text = without(profile, "<!--", "-->");
  return text.find("<Security>") != std::string::npos ||
         text.find("<DDSSecurity>") != std::string::npos;
}

std::string without_keys(const std::string& profile) {
  const std::string text = without(profile, "<!--", "-->");
  return without(without(text, "<Security>", "</Security>"), "<DDSSecurity>", "</DDSSecurity>");
}

fs::path keys_directory() {
  if (const char* keys = std::getenv("C3RT_KEYS"); keys != nullptr && *keys != '\0')
    return fs::absolute(keys);
  const char* settings = std::getenv("XDG_CONFIG_HOME");
  const char* home = std::getenv("HOME");
  const fs::path folder = settings != nullptr && *settings != '\0'
                              ? fs::path(settings)
                              : fs::path(home != nullptr ? home : "/") / ".config";
  return folder / "c3rt" / "keys";
}

fs::path security_plugins() {
  Dl_info library{};
  if (dladdr(reinterpret_cast<const void*>(&dds_create_domain), &library) == 0)
    throw WireError("cannot tell where the library of Cyclone DDS is");
  std::error_code error;
  const fs::path folder = fs::canonical(library.dli_fname, error).parent_path();
  std::vector<fs::path> candidates{folder};
  // Debian puts what no linker is to find into a folder of the package's name
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().rfind("libddsc", 0) == 0 && entry.is_directory(error))
      candidates.push_back(entry.path());
  }
  std::sort(candidates.begin() + 1, candidates.end());
  for (const fs::path& candidate : candidates)
    if (fs::exists(candidate / kPlugin, error)) return candidate;
  throw WireError(std::string("a secure profile needs ") + kPlugin + ", which is not beside " +
                  library.dli_fname +
                  " nor in a folder libddsc* there: is this Cyclone DDS built without security?");
}

std::string with_keys(const std::string& profile, const fs::path& keys,
                      const std::string& identity) {
  std::string text = profile;
  replace_all(text, "${C3RT_KEYS}", escaped(keys.string()));
  replace_all(text, "${C3RT_IDENTITY}", identity);
  replace_all(text, "${C3RT_DDS_SECURITY}", security_plugins().string());
  return text;
}

}  // namespace c3rt::wire
