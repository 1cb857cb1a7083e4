// Every topic read and written by a client that has nothing of ours but c3rt.idl and
// docs/clients.md: Python types from idl/generate.py and the package cyclonedds 11, while c3rt is
// on Cyclone DDS 0.10.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <fcntl.h>

#include "tests/idl/bus_fixture.hpp"
#include "tests/idl/samples.hpp"

using namespace c3rt;
using namespace c3rt::wire;
namespace test = c3rt::wire::test;

namespace {

using test::kDomain;
using test::kMs;
using test::kSecond;
using test::numbered;

constexpr int kSkipped = 77;  // SKIP_RETURN_CODE of the test
constexpr std::uint64_t kSession = 7;
constexpr std::int64_t kTime = kMs;

const std::string kSource = C3RT_SOURCE_DIRECTORY;
const std::string kPython = std::string(C3RT_THIRD_PARTY) + "/../python/bin/python";
const std::string kTypes = std::string(C3RT_BINARY_DIRECTORY) + "/idl/python";

std::string text_of(const std::string& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// The client; its words are in a file.
class Client {
 public:
  explicit Client(const std::string& words) {
    pid_ = fork();
    if (pid_ != 0) return;
    const int file = open(words.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
    dup2(file, 1);
    dup2(file, 2);
    setenv("CYCLONEDDS_URI", ("file://" + kSource + "/config/dds/loopback.xml").c_str(), 1);
    const std::string script = kSource + "/tests/idl/python_client.py",
                      page = kSource + "/docs/clients.md", domain = std::to_string(kDomain);
    execl(kPython.c_str(), kPython.c_str(), script.c_str(), page.c_str(), kTypes.c_str(),
          domain.c_str(), nullptr);
    _exit(127);
  }
  ~Client() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  bool lives() {
    if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == pid_) pid_ = -1;
    return pid_ > 0;
  }

 private:
  pid_t pid_;
};

/// A writer or a reader of one topic, its type forgotten.
struct Peer {
  virtual ~Peer() = default;
  virtual void turn() = 0;
  bool done = false;
};

template <typename T>
struct Sending : Peer {
  explicit Sending(Bus& bus) : writer(bus) {}
  void turn() override {
    T sample = numbered<T>();
    writer.write(sample, kTime);
  }
  Writer<T> writer;
};

template <typename T>
struct Receiving : Peer {
  explicit Receiving(Bus& bus) : reader(bus) {}
  void turn() override {
    T sample{};
    if (done || !reader.take(sample)) return;
    T expected = numbered<T>();
    expected.header = {kSession, sample.header.seq, kTime};
    INFO(topic<T>().name);
    CHECK(std::memcmp(&sample, &expected, sizeof sample) == 0);
    done = true;
  }
  Reader<T> reader;
};

template <template <typename> class Kind>
std::map<std::string, std::unique_ptr<Peer>> peers(Bus& bus) {
  std::map<std::string, std::unique_ptr<Peer>> all;
  for_each_topic([&](const auto& sample) {
    using T = std::decay_t<decltype(sample)>;
    all[topic<T>().name] = std::make_unique<Kind<T>>(bus);
  });
  return all;
}

}  // namespace

TEST_CASE("python client: it reads every topic and writes every topic, value by value") {
  if (!std::filesystem::exists(kPython)) {
    std::printf("SKIPPED: the package cyclonedds is not in %s (cmake/third_party.sh installs it)\n",
                kPython.c_str());
    std::fflush(stdout);
    std::_Exit(kSkipped);
  }
  const std::string words = std::string(C3RT_BINARY_DIRECTORY) + "/idl/python_client.log";
  std::filesystem::remove(words);
  Client client(words);
  const auto long_enough = [&](const std::function<bool()>& condition) {
    for (const std::int64_t end_ns = rt::now_ns() + 90 * kSecond; rt::now_ns() < end_ns;) {
      if (condition()) return true;
      if (!client.lives()) return false;
      usleep(20'000);
    }
    return false;
  };
  {
    Bus bus(test::settings(ClockMode::kRealtime, kSession));
    const auto writers = peers<Sending>(bus);
    const bool read = long_enough([&] {
      for (const auto& [name, writer] : writers) writer->turn();
      return text_of(words).find("read ") != std::string::npos;
    });
    INFO(text_of(words));
    REQUIRE(read);
  }
  Bus bus(test::settings(ClockMode::kRealtime, kSession));
  const auto readers = peers<Receiving>(bus);
  std::string missing;
  const bool written = long_enough([&] {
    missing.clear();
    for (const auto& [name, reader] : readers) {
      reader->turn();
      if (!reader->done) missing += " " + name;
    }
    return missing.empty();
  });
  INFO("not read:" << missing);
  INFO(text_of(words));
  for (const RefusedCount& refused : bus.refusals())
    UNSCOPED_INFO(refused.topic << " refused: " << refused.latest);
  for (const PeerProblem& problem : bus.problems()) UNSCOPED_INFO(problem.text);
  CHECK(written);
}
