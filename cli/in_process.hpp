#pragma once
// The four nodes in this process, in simulated time and without DDS: the order and the delays of
// lockstep, so the same samples.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "config/scenario.hpp"
#include "controller/impedance/node.hpp"
#include "controller/planner/service.hpp"
#include "idl/dds.hpp"
#include "plant_emulator/service.hpp"

namespace c3rt::cli {

class InProcess {
 public:
  using Log = std::function<void(wire::Process, bool attention, const std::string& sentence)>;
  /// @param bus with an exchange and a session. Who else reads or writes has a bus of its own on
  /// the same exchange.
  /// @throws what the nodes throw for a scenario that they cannot use
  InProcess(const config::Scenario& scenario, std::uint64_t seed, const wire::BusSettings& bus,
            const Log& log = {});
  ~InProcess();
  InProcess(const InProcess&) = delete;
  InProcess& operator=(const InProcess&) = delete;

  /// Somebody who acts in simulated time as the nodes do: in the first cycle, then at each multiple
  /// of its period.
  /// @param act is told what has been written up to then, for Bus::wait_for()
  void join(std::int64_t period_ns, std::function<void(const wire::Sequences&)> act);

  /// One cycle of the plant, and of everything that is due in it.
  void advance();
  std::int64_t now_ns() const noexcept;

  /// A process that does not run takes and sends nothing, as one that stalls or was killed. While
  /// the plant does not run, time goes on for the others alone.
  void set_running(wire::Process process, bool runs);
  /// Whose samples and readers they are, for bad lines to it: Bus::identity().
  std::uint64_t bus_of(wire::Process process) const;
  /// Started anew, without memory: planner, vision or impedance.
  void restart(wire::Process process);

  const plant::Node& plant() const;
  const planner::Node& planner() const;
  const impedance::Node& impedance() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace c3rt::cli
