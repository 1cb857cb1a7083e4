#pragma once
// What a planner, an estimator and a motion generator of one's own have in common: each plays one
// of c3rt's processes, in real time or in the plant's time (c3rt run|up --without …).
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "idl/client/client.hpp"

namespace c3rt::client {

/// The run is in lockstep and this process in realtime, or the other way round.
class WrongClock : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Somebody else plays this process already.
class Occupied : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Where and how a process takes part.
struct Place {
  std::uint32_t domain = 0;
  std::string profile = "loopback";
  wire::ClockMode clock = wire::ClockMode::kRealtime;
  std::uint64_t session = 0;  // 0: the plant's that is heard
};

/// Loop, status and requests around a class's own method. For one thread; one in a program, and no
/// Client beside it.
class Process {
 public:
  virtual ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Plays the process until SIGINT, SIGTERM or a shutdown request, in lockstep until the run is
  /// over.
  /// @throws WrongClock, Occupied, wire::WireError, std::invalid_argument, and what the class's own
  /// method throws
  void run(const Place& place);

  /// run() with the words of a command line, also those that c3rt gives its own processes.
  /// @return exit status: 0 ended as asked, 1 failed while running, 2 could not start; stderr says
  /// why
  int main(int argc, char** argv);

 protected:
  class Part;  // of one run()

  /// @param process that is played: the planner, vision or impedance
  explicit Process(wire::Process process);

  /// A sentence for `c3rt status`, while run() goes on.
  void say(const std::string& text, bool degraded = false);

 private:
  virtual std::unique_ptr<Part> take_part(const Place& place) = 0;

  const wire::Process process_;
  Part* part_ = nullptr;  // while run() goes on
  bool began_ = false;    // the class's own method was called
};

}  // namespace c3rt::client
