#include "cli/log_rotation.hpp"

#include <string>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <unistd.h>

#include "cli/paths.hpp"
#include "tests/cli/folder.hpp"

using namespace c3rt::cli;

namespace {

/// A process that says something: its log is open for as long as it runs.
class Writer {
 public:
  explicit Writer(const std::filesystem::path& log)
      : file_(open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {}
  ~Writer() { close(file_); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  void say(const std::string& text) {
    REQUIRE(write(file_, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  }

 private:
  int file_;
};

}  // namespace

TEST_CASE("log rotation: a log of the largest size stays, a larger one begins anew") {
  const Folder folder;
  const auto log = folder.path() / "plant.log";
  Writer writer(log);
  writer.say(std::string(100, 'a'));
  CHECK(rotate_log(log, 100).empty());
  CHECK(std::filesystem::file_size(log) == 100);
  writer.say("b");
  CHECK(rotate_log(log, 100).empty());
  CHECK(std::filesystem::file_size(log) == 0);
  CHECK(read_text(folder.path() / "plant.1.log") == std::string(100, 'a') + "b");
  // who writes it notices nothing
  writer.say("goes on\n");
  CHECK(read_text(log) == "goes on\n");
}

TEST_CASE("log rotation: however much is said, so many logs are kept and no more") {
  const Folder folder;
  const auto log = folder.path() / "planner.log";
  Writer writer(log);
  for (int i = 0; i < 20; ++i) {
    writer.say(std::to_string(i) + std::string(200, '.'));
    CHECK(rotate_logs(folder.path(), 100, 3).empty());
  }
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path()))
    ++files;
  CHECK(files == 4);
  CHECK(read_text(folder.path() / "planner.1.log").substr(0, 3) == "19.");
  CHECK(read_text(folder.path() / "planner.3.log").substr(0, 3) == "17.");
}

TEST_CASE("log rotation: what cannot be done is told, and the log stays as it is") {
  const Folder folder;
  const auto log = folder.path() / "vision.log";
  Writer(log).say(std::string(200, 'a'));
  std::filesystem::create_directories(log.string() + ".part");
  CHECK(rotate_log(log, 100).find("cannot begin " + log.string() + " anew: ") == 0);
  CHECK(std::filesystem::file_size(log) == 200);
  CHECK(rotate_log(folder.path() / "nobody.log", 100).empty());
  CHECK(rotate_logs(folder.path() / "nowhere", 100).empty());
}
