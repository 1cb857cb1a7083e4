#include "cli/chaos/world.hpp"

#include <cmath>
#include <csignal>

#include <fcntl.h>
#include <unistd.h>

#include "cli/chaos/lines.hpp"

namespace c3rt::cli::chaos {
namespace {

// Until a process that was killed is there again, as in real time: long enough for the robot to
// stop without its servo. [ns]
constexpr std::int64_t kAway_ns = 300'000'000;

}  // namespace

Extent extent_of(const config::Scenario& scenario) {
  Extent extent;
  for (const auto& object : scenario.plant.world.objects)
    extent.object_masses.push_back(object.object.mass);
  if (scenario.vision.source == vision::SourceKind::kCameras)
    extent.cameras = static_cast<int>(scenario.vision.cameras.size());
  return extent;
}

wire::FaultInject inject_of(const Fault& fault, const Extent& extent) {
  base::Random random(fault.seed);
  const auto one_of = [&random](std::size_t count) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(count));
  };
  wire::FaultInject sample{};
  sample.process = process_of(fault.target);
  sample.kind = fault.kind->injected;
  sample.duration_s = fault.duration;
  if (sample.kind == c3rt_v2_FAULT_PUSH_OBJECT && !extent.object_masses.empty()) {
    const std::size_t object = one_of(extent.object_masses.size());
    const double angle = 2.0 * M_PI * random.uniform();
    const double impulse = extent.object_masses[object] * fault.amount;
    sample.index = static_cast<std::int32_t>(object);
    sample.value[0] = impulse * std::cos(angle);
    sample.value[1] = impulse * std::sin(angle);
  }
  if (sample.kind == c3rt_v2_FAULT_FREEZE_CAMERA)
    sample.index = static_cast<std::int32_t>(one_of(static_cast<std::size_t>(extent.cameras)));
  return sample;
}

SimulatedWorld::SimulatedWorld(const config::Scenario& scenario, const wire::BusSettings& bus,
                               InProcess& nodes)
    : extent_(extent_of(scenario)),
      nodes_(nodes),
      exchange_(bus.exchange),
      bus_(bus),
      faults_(bus_) {}

void SimulatedWorld::begin(const Fault& fault, std::int64_t now_ns) {
  switch (fault.kind->act) {
    case Act::kKill:
      nodes_.set_running(process_of(fault.target), false);
      killed_.push_back({process_of(fault.target), now_ns + kAway_ns});
      return;
    case Act::kStop:
      nodes_.set_running(process_of(fault.target), false);
      return;
    case Act::kInject: {
      wire::FaultInject sample = inject_of(fault, extent_);
      faults_.write(sample, now_ns);
      return;
    }
    default:
      set_line(*exchange_, fault, nodes_.bus_of(edge_of(fault.target)->reader));
  }
}

void SimulatedWorld::end(const Fault& fault, std::int64_t) {
  switch (fault.kind->act) {
    case Act::kKill:
    case Act::kInject:  // ends by itself
      return;
    case Act::kStop:
      nodes_.set_running(process_of(fault.target), true);
      return;
    default:
      clear_line(*exchange_, fault, nodes_.bus_of(edge_of(fault.target)->reader));
  }
}

void SimulatedWorld::look(std::int64_t now_ns) {
  for (std::size_t i = 0; i < killed_.size();) {
    const Killed killed = killed_[i];
    if (now_ns < killed.back_ns) {
      ++i;
      continue;
    }
    nodes_.restart(killed.process);
    nodes_.set_running(killed.process, true);
    killed_.erase(killed_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

RealWorld::RealWorld(const Launch& launch, Pids pids)
    : extent_(extent_of(launch.scenario())),
      pids_(std::move(pids)),
      filler_(launch.out() / "filler"),
      bus_(launch.bus()),
      faults_(bus_) {}

RealWorld::~RealWorld() {
  if (!stopped_.empty()) signal(stopped_, SIGCONT);
  std::error_code none;
  std::filesystem::remove(filler_, none);
}

/// To the last byte.
void RealWorld::fill_disk() const {
  const int file = open(filler_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) return;
  static const std::vector<char> kBlock(std::size_t{64} * 1024);
  for (std::size_t size = kBlock.size(); size > 0;) {
    if (write(file, kBlock.data(), size) <= 0) size /= 2;
  }
  close(file);
}

void RealWorld::signal(const std::string& name, int number) const {
  for (const auto& [known, pid] : pids_()) {
    if (known == name) kill(pid, number);
  }
}

void RealWorld::begin(const Fault& fault, std::int64_t now_ns) {
  switch (fault.kind->act) {
    case Act::kKill:
    case Act::kKillService:
      signal(fault.target, SIGKILL);
      return;
    case Act::kStop:
      stopped_ = fault.target;
      signal(fault.target, SIGSTOP);
      return;
    case Act::kDouble:
    case Act::kFlood:
      stranger_.emplace(bus_, fault);
      return;
    case Act::kFillDisk:
      fill_disk();
      return;
    default:
      wire::FaultInject sample = inject_of(fault, extent_);
      faults_.write(sample, now_ns);
  }
}

void RealWorld::look(std::int64_t now_ns) {
  if (stranger_) stranger_->speak(now_ns);
}

void RealWorld::end(const Fault& fault, std::int64_t) {
  stranger_.reset();
  if (fault.kind->act == Act::kFillDisk) {
    std::error_code none;
    std::filesystem::remove(filler_, none);
  }
  if (fault.kind->act != Act::kStop) return;
  signal(stopped_, SIGCONT);
  stopped_.clear();
}

}  // namespace c3rt::cli::chaos
