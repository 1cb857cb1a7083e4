#pragma once
// What a hop over DDS costs: the servo's own path beside DDS alone, turn by turn, to another
// process and back.
#include <cstdint>
#include <functional>
#include <vector>

#include <sys/types.h>

#include "idl/dds.hpp"

namespace c3rt::cli::latency {

/// The process at the other end; it answers from begin() until it is ended, and dies with this one.
class EchoProcess {
 public:
  /// Forks: make it before this process has threads or a bus.
  /// @throws std::runtime_error
  EchoProcess(const wire::BusSettings& settings, int fifo_priority);
  ~EchoProcess();  // end()
  EchoProcess(const EchoProcess&) = delete;
  EchoProcess& operator=(const EchoProcess&) = delete;

  void begin();
  void end();
  bool running();

 private:
  pid_t pid_ = 0;
  int gate_ = -1;  // a word through this socket begins it, its end ends it
};

/// Half round trips [s].
struct HopRecord {
  std::vector<double> layer;  // robot/state there, robot/command back, as plant and servo do
  std::vector<double> raw;    // the same types by Cyclone alone
  std::uint64_t sent = 0, lost = 0;
  bool answered = false;  // the other end was found
  bool died = false;      // and was gone before the time was over
};

/// Begins the other end and sends both kinds in turn, one a millisecond, for so long or until
/// `stop`.
/// @param shown gets the share that is done
HopRecord measure_hops(const wire::BusSettings& settings, EchoProcess& echo, double duration_s,
                       int fifo_priority, const std::function<bool()>& stop,
                       const std::function<void(double)>& shown);

}  // namespace c3rt::cli::latency
