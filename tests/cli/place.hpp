#pragma once
// The command as a person meets it: the built program, in a place of its own.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <signal.h>

#include "tests/cli/folder.hpp"
#include "tests/support/outcome.hpp"

namespace c3rt::cli {

/// Locks, results and the four "processes": small shells, or what process() puts there.
class Place {
 public:
  explicit Place(int domain = 97) : domain_(domain) {
    std::filesystem::create_directories(folder_.path() / "run" / "c3rt");
    std::filesystem::create_directories(folder_.path() / "bin");
    for (const char* name : kProcesses) process(name, "exec sleep 300");
  }
  /// Puts a shell script in the place of c3rt-NAME; it leaves its pid behind.
  void process(const std::string& name, const std::string& script) const {
    const std::filesystem::path file = folder_.path() / "bin" / ("c3rt-" + name);
    const std::filesystem::path part = file.string() + ".part";
    std::ofstream(part) << "#!/bin/bash\necho $$ > " << pid_file(name).string() << "\n"
                        << script << "\n";
    std::filesystem::permissions(part, std::filesystem::perms::owner_all);
    std::filesystem::rename(part, file);
  }
  /// @param runtime another folder of locks: as another user would have
  std::string command(const std::string& arguments, const std::string& runtime = "run") const {
    return "XDG_RUNTIME_DIR='" + (folder_.path() / runtime).string() +
           "' C3RT_PROCESS_DIRECTORY='" + (folder_.path() / "bin").string() +
           "' '" C3RT_BINARY_DIRECTORY "/bin/c3rt' " + arguments;
  }
  support::Outcome c3rt(const std::string& arguments, const std::string& runtime = "run") const {
    return support::outcome_of(command(arguments, runtime));
  }
  std::string on_domain() const { return " --domain " + std::to_string(domain_); }
  std::string start_options() const {
    return on_domain() + " --out '" + (folder_.path() / "out").string() + "'";
  }
  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path locks() const { return folder_.path() / "run" / "c3rt"; }
  std::filesystem::path out() const { return folder_.path() / "out"; }
  std::filesystem::path pid_file(const std::string& name) const {
    return folder_.path() / (name + ".pid");
  }
  pid_t pid(const std::string& name) const {
    pid_t pid = 0;
    std::ifstream(pid_file(name)) >> pid;
    return pid;
  }
  bool started(const std::string& name) const { return pid(name) > 0; }
  /// No process of this place is running.
  bool empty() const {
    for (const char* name : kProcesses) {
      if (const pid_t process = pid(name); process > 0 && kill(process, 0) == 0) return false;
    }
    return true;
  }

 private:
  static constexpr const char* kProcesses[] = {"plant", "impedance", "planner", "vision"};
  int domain_;
  Folder folder_;
};

}  // namespace c3rt::cli
