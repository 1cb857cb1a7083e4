#include "cli/replay/alone.hpp"

#include <functional>
#include <optional>
#include <string>

#include "cli/services.hpp"
#include "controller/base/time.hpp"

namespace c3rt::cli::replay {
namespace {

wire::BusSettings settings_of(const std::shared_ptr<wire::Exchange>& exchange,
                              std::uint64_t session) {
  wire::BusSettings settings;
  settings.clock = wire::ClockMode::kLockstep;
  settings.session_id = session;
  settings.exchange = exchange;
  return settings;
}

wire::FaultScope scope_of(const config::Scenario& scenario, wire::Process process) {
  return process == c3rt_v2_PROCESS_VISION ? vision::fault_scope(scenario.vision)
                                           : wire::FaultScope{};
}

}  // namespace

struct Alone::Work {
  Work(const config::Scenario& s, wire::Process process, std::uint64_t seed,
       const wire::BusSettings& settings)
      : bus(settings), endpoint(bus, process, scope_of(s, process), {}) {
    switch (process) {
      case c3rt_v2_PROCESS_PLANNER:
        period_s = 1.0 / s.planner.rate;
        start(planner, bus, endpoint, s, seed);
        return;
      case c3rt_v2_PROCESS_VISION:
        period_s = 1.0 / s.vision.rate;
        start(vision, bus, endpoint, s, seed);
        return;
      case c3rt_v2_PROCESS_IMPEDANCE:
        period_s = s.impedance.period;
        impedance.emplace(bus, endpoint, s);
        return;
      default:
        throw wire::WireError(std::string("no process alone: ") + wire::process_name(process));
    }
  }
  void step(std::int64_t now_ns) {
    if (planner) planner->step(now_ns);
    if (vision) vision->step(now_ns);
    if (!impedance) return;
    impedance->servo.cycle(now_ns);
    impedance->service.poll(now_ns);
  }
  wire::Bus bus;
  wire::Endpoint endpoint;
  double period_s = 0.0;
  std::optional<planner::Service> planner;
  std::optional<vision::Service> vision;
  std::optional<Impedance> impedance;
};

Alone::Alone(const config::Scenario& scenario, wire::Process process, std::uint64_t seed,
             std::uint64_t session)
    : exchange_(wire::make_exchange()),
      ears_(settings_of(exchange_, session)),
      work_(std::make_unique<Work>(scenario, process, seed, settings_of(exchange_, session))) {}
Alone::~Alone() = default;

wire::Sender Alone::sender_of(const wire::Topic& topic) {
  const auto somebody = [this] {
    return wire::Sender{exchange_->identity(), exchange_->identity()};
  };
  // each client counts its own samples from 1
  if (!topic.writer) return somebody();
  const auto known = senders_.find(topic.name);
  return known != senders_.end() ? known->second
                                 : senders_.emplace(topic.name, somebody()).first->second;
}

void Alone::step(std::int64_t now_ns) { work_->step(now_ns); }
std::int64_t Alone::period_ns() const { return base::nanoseconds(work_->period_s); }

}  // namespace c3rt::cli::replay
