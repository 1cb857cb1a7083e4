#include "cli/lock.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <thread>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#include "cli/paths.hpp"

namespace c3rt::cli {
namespace {

using nlohmann::json;

std::filesystem::path lock_file(const std::filesystem::path& directory, std::uint32_t domain) {
  return directory / ("domain-" + std::to_string(domain) + ".lock");
}

std::optional<Instance> read(const std::filesystem::path& file) {
  std::ifstream stream(file);
  const json note = json::parse(stream, nullptr, false);
  if (!note.is_object()) return std::nullopt;
  Instance instance;
  instance.pid = note.value("pid", 0);
  instance.verb = note.value("verb", "");
  instance.scenario = note.value("scenario", "");
  instance.file = note.value("file", "");
  instance.overrides = note.value("overrides", std::vector<std::string>{});
  instance.clock = note.value("clock", "");
  instance.session = note.value("session", std::uint64_t{0});
  instance.seed = note.value("seed", std::uint64_t{0});
  instance.profile = note.value("profile", "");
  instance.out = note.value("out", "");
  instance.started = note.value("started", "");
  instance.ended = note.value("ended", "");
  instance.notes = note.value("notes", std::vector<std::string>());
  return instance;
}

constexpr std::uint32_t kFirstAny = 101, kLastAny = 230;

/// Nobody on this host listens where the first participant of the domain would: also those that
/// know nothing of our locks. (DDSI-RTPS 9.6.1.1: port = 7400 + 250 domain + 10 + 2 index)
bool silent(std::uint32_t domain) {
  const int socket_handle = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_handle < 0) return true;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(static_cast<std::uint16_t>(7410 + 250 * domain));
  const bool free = bind(socket_handle, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  close(socket_handle);
  return free;
}

bool take(int file, std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (flock(file, LOCK_EX | LOCK_NB) != 0) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace

DomainLock::DomainLock(const std::filesystem::path& directory, std::uint32_t domain,
                       const Instance& self, std::chrono::milliseconds patience)
    : domain_(domain), self_(self) {
  const std::filesystem::path path = lock_file(directory, domain);
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0)
    throw UsageError("cannot open the lock " + path.string() + ": " + std::strerror(errno));
  if (!take(file_, patience)) {
    close(file_);
    std::string who = "another c3rt holds it";
    if (const auto other = read(path)) {
      who = "c3rt " + other->verb + " " + other->scenario + " (pid " + std::to_string(other->pid) +
            ", since " + other->started + ") holds it";
    }
    throw DomainBusy("DDS domain " + std::to_string(domain) + " is busy: " + who +
                     "; end it with \"c3rt down --domain " + std::to_string(domain) +
                     "\" or choose another --domain");
  }
  write();
}

DomainLock::~DomainLock() { close(file_); }

void DomainLock::set_ended(const std::string& how) {
  self_.ended = how;
  write();
}

void DomainLock::set_notes(const std::vector<std::string>& notes) {
  self_.notes = notes;
  write();
}

void DomainLock::write() const {
  const json note{
      {"pid", self_.pid},         {"verb", self_.verb},           {"scenario", self_.scenario},
      {"file", self_.file},       {"overrides", self_.overrides}, {"clock", self_.clock},
      {"session", self_.session}, {"seed", self_.seed},           {"profile", self_.profile},
      {"out", self_.out},         {"started", self_.started},     {"ended", self_.ended},
      {"notes", self_.notes}};
  const std::string text = note.dump() + "\n";
  const bool written = ftruncate(file_, 0) == 0 && pwrite(file_, text.data(), text.size(), 0) ==
                                                       static_cast<ssize_t>(text.size());
  if (!written) throw UsageError(std::string("cannot write the lock: ") + std::strerror(errno));
}

std::unique_ptr<DomainLock> lock_any_domain(const std::filesystem::path& directory,
                                            const Instance& self) {
  // from the end that nobody takes by hand
  for (std::uint32_t domain = kLastAny; domain >= kFirstAny; --domain) {
    try {
      auto lock =
          std::make_unique<DomainLock>(directory, domain, self, std::chrono::milliseconds(0));
      if (silent(domain)) return lock;
    } catch (const DomainBusy&) {
    }
  }
  throw UsageError("the DDS domains " + std::to_string(kFirstAny) + " to " +
                   std::to_string(kLastAny) + " are all busy");
}

std::optional<Instance> holder(const std::filesystem::path& directory, std::uint32_t domain) {
  const std::filesystem::path path = lock_file(directory, domain);
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  const bool is_free = flock(file, LOCK_SH | LOCK_NB) == 0;
  close(file);
  return is_free ? std::nullopt : read(path);
}

std::optional<Instance> last_instance(const std::filesystem::path& directory,
                                      std::uint32_t domain) {
  return read(lock_file(directory, domain));
}

}  // namespace c3rt::cli
