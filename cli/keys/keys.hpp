#pragma once
// c3rt keys: what a secure bus needs, made and looked at.
#include <string>
#include <vector>

namespace c3rt::cli::keys {

struct Settings {
  std::string folder;  // "": that of the environment
  int days = 365;
  bool force = false;
  std::vector<std::string> identities;  // none: all
};

/// Makes a keystore. @return an exit status @throws UsageError
int init(const Settings& settings);

/// Says what is wrong with the keys, and until when they are valid. @return an exit status: 1 where
/// something is wrong
int check(const Settings& settings);

}  // namespace c3rt::cli::keys
