#pragma once
// What faults act upon: nodes in this process, or processes.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/chaos/schedule.hpp"
#include "cli/chaos/stranger.hpp"
#include "cli/in_process.hpp"
#include "cli/launch.hpp"
#include "idl/exchange.hpp"

namespace c3rt::cli::chaos {

class World {
 public:
  World() = default;
  virtual ~World() = default;
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  virtual void begin(const Fault& fault, std::int64_t now_ns) = 0;
  virtual void end(const Fault& fault, std::int64_t now_ns) = 0;
  /// What follows of faults by itself.
  virtual void look(std::int64_t) {}
};

/// What the scenario's objects and cameras allow of a fault that its processes offer themselves.
struct Extent {
  std::vector<double> object_masses;  // [kg]
  int cameras = 0;
};
Extent extent_of(const config::Scenario& scenario);

/// The sample that asks a process for such a fault.
wire::FaultInject inject_of(const Fault& fault, const Extent& extent);

/// Of a run in one process. Faults begin and end between two cycles.
class SimulatedWorld final : public World {
 public:
  /// @param bus with the exchange of the nodes
  SimulatedWorld(const config::Scenario& scenario, const wire::BusSettings& bus, InProcess& nodes);
  void begin(const Fault& fault, std::int64_t now_ns) override;
  void end(const Fault& fault, std::int64_t now_ns) override;
  void look(std::int64_t now_ns) override;

 private:
  struct Killed {
    wire::Process process;
    std::int64_t back_ns;
  };
  const Extent extent_;
  std::vector<Killed> killed_;
  InProcess& nodes_;
  const std::shared_ptr<wire::Exchange> exchange_;
  wire::Bus bus_;
  wire::Writer<wire::FaultInject> faults_;
};

/// Of processes of this host.
class RealWorld final : public World {
 public:
  /// The processes that run, with their process ids; the supervisor's where it is one of them.
  using Pids = std::function<std::vector<std::pair<std::string, pid_t>>()>;
  RealWorld(const Launch& launch, Pids pids);
  ~RealWorld() override;  // nobody stays stopped
  void begin(const Fault& fault, std::int64_t now_ns) override;
  void end(const Fault& fault, std::int64_t now_ns) override;
  void look(std::int64_t now_ns) override;

 private:
  void signal(const std::string& name, int number) const;
  const Extent extent_;
  void fill_disk() const;
  const Pids pids_;
  const std::filesystem::path filler_;  // what fills the disk
  std::string stopped_;                 // who stands still; empty: nobody
  wire::Bus bus_;
  wire::Writer<wire::FaultInject> faults_;
  std::optional<Stranger> stranger_;
};

}  // namespace c3rt::cli::chaos
