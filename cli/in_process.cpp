#include "cli/in_process.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "cli/services.hpp"
#include "controller/base/time.hpp"
#include "idl/exchange.hpp"

namespace c3rt::cli {
namespace {

/// When somebody acts: in the first cycle, then at each multiple of its period, as Loop in
/// lockstep.
class Pace {
 public:
  explicit Pace(std::int64_t period_ns) : period_ns_(period_ns) {}
  bool due(std::int64_t now_ns) noexcept {
    if (now_ns < next_ns_) return false;
    next_ns_ = (now_ns / period_ns_ + 1) * period_ns_;
    return true;
  }

 private:
  std::int64_t period_ns_, next_ns_ = 0;
};

/// What every process has.
struct Seat {
  Seat(const wire::BusSettings& settings, wire::Process process, const wire::FaultScope& scope,
       std::int64_t period_ns, const InProcess::Log& log)
      : bus(settings), endpoint(bus, process, scope, log_of(process, log)), pace(period_ns) {
    bus.hold_until_promised();
  }
  static wire::Endpoint::Log log_of(wire::Process process, const InProcess::Log& log) {
    if (!log) return {};
    return
        [process, log](bool attention, const std::string& said) { log(process, attention, said); };
  }
  wire::Bus bus;
  wire::Endpoint endpoint;
  Pace pace;
  bool runs = true;
};

struct Guest {
  Pace pace;
  std::function<void(const wire::Sequences&)> act;
};

}  // namespace

struct InProcess::Implementation {
  Implementation(const config::Scenario& s, std::uint64_t the_seed,
                 const wire::BusSettings& settings, const Log& log)
      : scenario(s),
        seed(the_seed),
        exchange(settings.exchange),
        plant_seat(settings, c3rt_v2_PROCESS_PLANT, plant::fault_scope(s.plant), plant::kCycleNs,
                   log),
        impedance_seat(settings, c3rt_v2_PROCESS_IMPEDANCE, {},
                       base::nanoseconds(s.impedance.period), log),
        planner_seat(settings, c3rt_v2_PROCESS_PLANNER, {}, base::nanoseconds(1.0 / s.planner.rate),
                     log),
        vision_seat(settings, c3rt_v2_PROCESS_VISION, vision::fault_scope(s.vision),
                    base::nanoseconds(1.0 / s.vision.rate), log),
        plant_node(s.plant, s.vision.rate, seed),
        plant(plant_seat.bus, plant_seat.endpoint, plant_node) {
    for (const wire::Process process :
         {c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION})
      start(process);
  }

  void start(wire::Process process) {
    switch (process) {
      case c3rt_v2_PROCESS_IMPEDANCE:
        impedance.reset();
        impedance.emplace(impedance_seat.bus, impedance_seat.endpoint, scenario);
        return;
      case c3rt_v2_PROCESS_PLANNER:
        cli::start(planner, planner_seat.bus, planner_seat.endpoint, scenario, seed);
        return;
      case c3rt_v2_PROCESS_VISION:
        cli::start(vision, vision_seat.bus, vision_seat.endpoint, scenario, seed);
        return;
      default:
        throw wire::WireError(std::string("within one process ") + wire::process_name(process) +
                              " cannot be started anew");
    }
  }

  Seat& seat(wire::Process process) {
    switch (process) {
      case c3rt_v2_PROCESS_PLANT:
        return plant_seat;
      case c3rt_v2_PROCESS_IMPEDANCE:
        return impedance_seat;
      case c3rt_v2_PROCESS_PLANNER:
        return planner_seat;
      case c3rt_v2_PROCESS_VISION:
        return vision_seat;
      default:
        throw wire::WireError(std::string("no seat for ") + wire::process_name(process));
    }
  }

  /// What the nodes have written up to now.
  void written(wire::Sequences& newest) const {
    std::fill(std::begin(newest), std::end(newest), 0);
    for (const Seat* of : {&plant_seat, &impedance_seat, &planner_seat, &vision_seat}) {
      wire::Sequences its{};
      of->bus.newest_written(its);
      for (std::size_t i = 0; i < std::size(newest); ++i) newest[i] = std::max(newest[i], its[i]);
    }
  }

  static void promise(wire::Bus& bus, const wire::Sequences& newest) {
    std::string missing;
    if (!bus.wait_for(newest, 0, missing))
      throw wire::WireError("a sample of " + missing + " did not arrive");
  }

  /// Whether it is to act now; then it sees what was written before.
  static bool due(Seat& seat, std::int64_t now_ns, const wire::Sequences& newest) {
    if (!seat.pace.due(now_ns) || !seat.runs) return false;
    promise(seat.bus, newest);
    return true;
  }

  void advance() {
    now_ns += plant::kCycleNs;  // time begins at one cycle: 0 means "none" in a stamp
    exchange->arrive(now_ns);
    if (now_ns == plant::kCycleNs) plant.send(plant_node.start(now_ns), now_ns);
    wire::Sequences newest{};
    written(newest);
    if (due(impedance_seat, now_ns, newest)) {
      impedance->servo.cycle(now_ns);
      if (impedance->service.poll(now_ns))
        impedance_seat.endpoint.tell(false, impedance->service.text());
    }
    if (due(planner_seat, now_ns, newest)) planner->step(now_ns);
    if (due(vision_seat, now_ns, newest)) vision->step(now_ns);
    for (Guest& guest : guests) {
      if (guest.pace.due(now_ns)) guest.act(newest);
    }
    if (!plant_seat.runs) return;
    written(newest);
    promise(plant_seat.bus, newest);
    plant.serve(now_ns);
    plant.step(now_ns, now_ns + plant::kCycleNs);
  }

  const config::Scenario scenario;
  const std::uint64_t seed;
  const std::shared_ptr<wire::Exchange> exchange;
  Seat plant_seat, impedance_seat, planner_seat, vision_seat;
  plant::Node plant_node;
  plant::Service plant;
  std::optional<Impedance> impedance;
  std::optional<planner::Service> planner;
  std::optional<vision::Service> vision;
  std::vector<Guest> guests;
  std::int64_t now_ns = 0;
};

InProcess::InProcess(const config::Scenario& scenario, std::uint64_t seed,
                     const wire::BusSettings& bus, const Log& log)
    : implementation_(std::make_unique<Implementation>(scenario, seed, bus, log)) {}
InProcess::~InProcess() = default;

void InProcess::join(std::int64_t period_ns, std::function<void(const wire::Sequences&)> act) {
  implementation_->guests.push_back({Pace(period_ns), std::move(act)});
}

void InProcess::advance() { implementation_->advance(); }
std::int64_t InProcess::now_ns() const noexcept { return implementation_->now_ns; }

void InProcess::set_running(wire::Process process, bool runs) {
  implementation_->seat(process).runs = runs;
}
std::uint64_t InProcess::bus_of(wire::Process process) const {
  return implementation_->seat(process).bus.identity();
}
void InProcess::restart(wire::Process process) { implementation_->start(process); }

const plant::Node& InProcess::plant() const { return implementation_->plant_node; }
const planner::Node& InProcess::planner() const { return implementation_->planner->node(); }
const impedance::Node& InProcess::impedance() const {
  return implementation_->impedance->servo.node();
}

}  // namespace c3rt::cli
