#pragma once
// A secure bus (DDS-Security): who may read and write which topic, from the table of topics, and
// how a profile gets its keys. The keys themselves are made and checked by cli/keys.
#include <array>
#include <filesystem>
#include <string>

#include "idl/topics.hpp"

namespace c3rt::wire {

/// A party of the bus with keys of its own: a folder of the keystore.
struct Identity {
  const char* name;  // "planner"; "client" of commands, recorders and programs of others
  Parties party;
};
inline constexpr std::array<Identity, 5> kIdentities = {{{"plant", party::kPlant},
                                                         {"impedance", party::kImpedance},
                                                         {"planner", party::kPlanner},
                                                         {"vision", party::kVision},
                                                         {"client", party::kClients}}};

/// Files of a keystore. Those of an identity lie in a folder of its name.
namespace key_file {
constexpr const char* kAuthority = "ca.crt";  // whom everybody trusts
constexpr const char* kAuthorityKey = "ca.key";
constexpr const char* kGovernance = "governance.p7s";
constexpr const char* kCertificate = "identity.crt";
constexpr const char* kKey = "identity.key";
constexpr const char* kPermissions = "permissions.p7s";
}  // namespace key_file

/// What every participant demands: nobody without keys, everything encrypted, access by topic.
std::string governance();

/// What one identity may read and write, in every domain.
/// @param subject name in its certificate, as RFC 2253 writes it
/// @param not_before, not_after in UTC: "2026-11-29T00:00:00"
std::string permissions(const Identity& identity, const std::string& subject,
                        const std::string& not_before, const std::string& not_after);

/// The text of a DDS profile demands keys.
bool is_secure(const std::string& profile);

/// The profile without what makes it secure.
std::string without_keys(const std::string& profile);

/// C3RT_KEYS, else c3rt/keys in the person's folder of settings (XDG_CONFIG_HOME, ~/.config).
std::filesystem::path keys_directory();

/// The folder of Cyclone's security plugins, found from where the library itself was loaded.
/// @throws WireError that names where it looked
std::filesystem::path security_plugins();

/// A secure profile with its places filled in: ${C3RT_KEYS}, ${C3RT_IDENTITY} and
/// ${C3RT_DDS_SECURITY}. A program of others may give them by its environment instead.
/// @throws WireError where the plugins are missing
std::string with_keys(const std::string& profile, const std::filesystem::path& keys,
                      const std::string& identity);

}  // namespace c3rt::wire
