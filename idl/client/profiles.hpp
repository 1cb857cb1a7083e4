#pragma once
// The DDS profiles of config/dds, known by name to a program that has no files of ours.
#include <string>

namespace c3rt::client {

/// What BusSettings::profile_uri takes for a profile.
/// @param profile loopback, lan, secure, secure_lan, or a DDS profile's file
/// @throws wire::ProfileError for what is none of them
std::string profile_uri(const std::string& profile);

}  // namespace c3rt::client
