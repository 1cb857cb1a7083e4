#include "cli/keys/keys.hpp"

#include <ctime>
#include <filesystem>

#include <fmt/format.h>

#include "cli/exit_status.hpp"
#include "cli/keys/keystore.hpp"
#include "idl/security.hpp"

namespace c3rt::cli::keys {
namespace fs = std::filesystem;
namespace {

fs::path folder_of(const Settings& settings) {
  return settings.folder.empty() ? wire::keys_directory() : fs::absolute(settings.folder);
}

}  // namespace

int init(const Settings& settings) {
  const fs::path folder = folder_of(settings);
  const std::time_t now = std::time(nullptr);
  make(folder, settings.days, settings.force, now);
  fmt::print("keys of {} are in {}, valid for {} days\n", fmt::join(identity_names(), ", "),
             folder.string(), settings.days);
  if (folder != wire::keys_directory())
    fmt::print("take them: export C3RT_KEYS={}\n", folder.string());
  fmt::print(
      "start with them: c3rt up SCENARIO --profile secure\n"
      "another host gets ca.crt, governance.p7s and the folders of those that run there; ca.key "
      "stays here\n");
  return kDone;
}

int check(const Settings& settings) {
  const fs::path folder = folder_of(settings);
  const std::vector<std::string> identities =
      settings.identities.empty() ? identity_names() : settings.identities;
  const Findings found = check(folder, identities, std::time(nullptr));
  for (const Complaint& complaint : found.problems)
    fmt::print(stderr, "c3rt: {}\n  {}\n", complaint.text, complaint.advice);
  if (!found.problems.empty()) return kCriterionFailed;
  fmt::print("keys of {} in {} are good until {}\n", fmt::join(identities, ", "), folder.string(),
             date(found.expires));
  return kDone;
}

}  // namespace c3rt::cli::keys
