#pragma once
// A planner of one's own in the place of c3rt-planner: a class with one method, in real time or in
// the plant's time (c3rt run|up --without planner).
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "idl/client/client.hpp"
#include "idl/client/motion.hpp"

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

struct PlannerSettings {
  double rate = 100.0;     // plans a second, 1 to 1000 [Hz]
  double delay = 0.0075;   // a plan takes effect so long after the state that it was made from [s]
  double valid_for = 0.1;  // after that the arm holds; at most 10 [s]
};

/// Where and how a planner takes part.
struct PlannerPlace {
  std::uint32_t domain = 0;
  std::string profile = "loopback";
  wire::ClockMode clock = wire::ClockMode::kRealtime;
  std::uint64_t session = 0;  // 0: the plant's that is heard
};

/// For one thread; one in a program, and no Client beside it.
class Planner {
 public:
  /// @throws std::invalid_argument naming the setting
  explicit Planner(const PlannerSettings& settings = {});
  virtual ~Planner();
  Planner(const Planner&) = delete;
  Planner& operator=(const Planner&) = delete;

  /// Once a period. In lockstep it must depend on nothing but what it is given, so that the same
  /// run gives the same bits. What it throws ends the process, as FAILED on service/status.
  virtual Motion plan(const Situation& now) = 0;
  /// A client's task. @throws std::invalid_argument saying why it is not taken; here none is
  virtual void target(const std::string& kind, const std::vector<Parameter>& parameters);

  /// Plays the planner until SIGINT, SIGTERM or a shutdown request, in lockstep until the run is
  /// over. After `c3rt stop` the arm is held and plan() is not called.
  /// @throws WrongClock, Occupied, wire::WireError, std::invalid_argument, and what plan() throws
  void run(const PlannerPlace& place);

  /// run() with the words of a command line, also those that c3rt gives its own processes.
  /// @return exit status: 0 ended as asked, 1 failed while running, 2 could not start; stderr says
  /// why
  int main(int argc, char** argv);

 protected:
  /// A sentence for `c3rt status`, while run() goes on.
  void say(const std::string& text, bool degraded = false);

 private:
  class Part;
  const PlannerSettings settings_;
  Part* part_ = nullptr;  // while run() goes on
  bool began_ = false;    // has been asked for a plan
};

}  // namespace c3rt::client
