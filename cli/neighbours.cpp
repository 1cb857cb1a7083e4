#include "cli/neighbours.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include <pwd.h>
#include <sys/stat.h>

#include "config/text.hpp"
#include "idl/discovery.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace {

using std::chrono::steady_clock;

// who writes these moves a robot or speaks for a process; a client's own camera or planner does not
constexpr const char* kTopics[] = {"robot/state", "robot/command", "sim/tick", "service/status"};

bool is_here(const Neighbour& neighbour) { return neighbour.host == wire::host_name(); }

/// A process of this host that has just died is still known on the bus for a while.
bool lives(const Neighbour& neighbour) {
  if (!is_here(neighbour) || neighbour.pid <= 0) return true;
  if (kill(neighbour.pid, 0) != 0 && errno != EPERM) return false;
  // dead, but nobody has asked for its exit status yet: pid (name) Z
  std::ifstream file("/proc/" + std::to_string(neighbour.pid) + "/stat");
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(')');
  return name_end == std::string::npos || line.compare(name_end, 3, ") Z") != 0;
}

std::string owner_of(int pid) {
  struct stat process {};
  if (stat(("/proc/" + std::to_string(pid)).c_str(), &process) != 0) return "";
  const passwd* user = getpwuid(process.st_uid);
  return user != nullptr ? user->pw_name : std::to_string(process.st_uid);
}

Neighbour neighbour_of(const wire::PeerEndpoint& peer) {
  Neighbour neighbour{peer.process, peer.host, "", peer.pid};
  if (is_here(neighbour)) neighbour.user = owner_of(peer.pid);
  return neighbour;
}

std::vector<Neighbour> look(const wire::Bus& bus) {
  std::vector<Neighbour> all;
  for (const wire::PeerEndpoint& peer : wire::peer_endpoints(bus)) {
    const bool counts =
        peer.is_writer && std::any_of(std::begin(kTopics), std::end(kTopics),
                                      [&](const char* topic) { return peer.topic == topic; });
    const bool known = std::any_of(all.begin(), all.end(), [&](const Neighbour& neighbour) {
      return neighbour.pid == peer.pid && neighbour.host == peer.host;
    });
    if (!counts || known) continue;
    const Neighbour neighbour = neighbour_of(peer);
    if (lives(neighbour)) all.push_back(neighbour);
  }
  return all;
}

}  // namespace

std::string Neighbour::text() const {
  std::string inside = pid > 0 ? "pid " + std::to_string(pid) : "";
  const auto add = [&inside](const std::string& what) {
    inside += (inside.empty() ? "" : ", ") + what;
  };
  if (!user.empty()) add("user " + user);
  if (!host.empty() && !is_here(*this)) add("on " + config::printable(host));
  const std::string name = process.empty() ? "another program" : config::printable(process);
  return inside.empty() ? name : name + " (" + inside + ")";
}

std::map<std::string, Neighbour> writers(const wire::Bus& bus) {
  std::map<std::string, Neighbour> all;
  for (const wire::PeerEndpoint& peer : wire::peer_endpoints(bus)) {
    if (!peer.is_writer || all.count(peer.topic) > 0) continue;
    const Neighbour neighbour = neighbour_of(peer);
    if (lives(neighbour)) all[peer.topic] = neighbour;
  }
  return all;
}

std::vector<Neighbour> neighbours(const wire::Bus& bus, double seconds) {
  const auto deadline = steady_clock::now() + std::chrono::duration<double>(seconds);
  std::vector<Neighbour> found;
  while (found.empty() && steady_clock::now() < deadline && !wire::StopFlag::requested()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    found = look(bus);
  }
  if (found.empty()) return found;
  // the rest of them is found a moment later; who is just ending, on a busy machine too, ends
  for (int i = 0; i < 10 && !found.empty() && !wire::StopFlag::requested(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    found = look(bus);
  }
  return found;
}

std::string text(const std::vector<Neighbour>& all) {
  std::string result;
  for (const Neighbour& neighbour : all) result += (result.empty() ? "" : ", ") + neighbour.text();
  return result;
}

}  // namespace c3rt::cli
