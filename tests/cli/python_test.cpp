#include "cli/python.hpp"

#include <cstdlib>
#include <fstream>

#include <catch2/catch.hpp>

#include "tests/cli/folder.hpp"

using namespace c3rt::cli;
namespace fs = std::filesystem;

namespace {

/// An environment variable for one test.
class Setting {
 public:
  Setting(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Setting() { before_.empty() ? unsetenv(name_) : setenv(name_, before_.c_str(), 1); }
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  const char* name_;
  std::string before_;
};

std::string program(const fs::path& file, const std::string& script) {
  std::ofstream(file) << "#!/bin/sh\n" << script << "\n";
  fs::permissions(file, fs::perms::owner_all);
  return file.string();
}

}  // namespace

TEST_CASE("python: what C3RT_PYTHON names is taken, and no other") {
  const Folder folder;
  const std::string own = program(folder.path() / "own", "exec /usr/bin/python3 \"$@\"");
  {
    const Setting chosen("C3RT_PYTHON", own);
    CHECK(find_python({"json", "sqlite3"}).program == own);
    const FoundPython none = find_python({"json", "c3rt_no_such_package"});
    CHECK(none.program.empty());
    CHECK(none.missing ==
          "no Python with the package json and c3rt_no_such_package (looked at: " + own +
              "); install it (Debian: python3-json python3-c3rt_no_such_package; pip: json "
              "c3rt_no_such_package) or name a Python that has it in C3RT_PYTHON");
  }
  const Setting chosen("C3RT_PYTHON", "/bin/false");
  CHECK(find_python({}).program.empty());
}

TEST_CASE("python: where that of the PATH lacks a package, Debian's is taken") {
  const Folder folder;
  program(folder.path() / "python3", "exit 1");
  const Setting path("PATH", folder.path().string() + ":" + std::getenv("PATH"));
  CHECK(find_python({"json"}).program == "/usr/bin/python3");
}

TEST_CASE("python: the package of the sources comes before what the environment has") {
  CHECK(fs::exists(fs::path(package_path()) / "c3rt" / "pictures" / "__init__.py"));
  const std::string alone = package_path();
  const Setting path("PYTHONPATH", "/some/where");
  CHECK(package_path() == alone + ":/some/where");
}
