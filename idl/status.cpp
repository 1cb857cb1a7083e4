#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <iterator>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/text.hpp"

namespace c3rt::wire {

namespace {

constexpr std::int64_t kPeriod_ns = 100'000'000;
constexpr int kProblemsEvery = 10;      // reports between two looks at the peers
constexpr std::size_t kMostTold = 200;  // a peer with a new name every second shall fill no disk
constexpr int kRateOver = 10;           // reports that the measured rate is averaged over

Quantiles to_wire(const rt::Quantiles& quantiles) {
  return {quantiles.count, quantiles.p50_s,  quantiles.p95_s,
          quantiles.p99_s, quantiles.p999_s, quantiles.max_s};
}

void show(const std::vector<RefusedCount>& refusals, RefusedSamples (&out)[c3rt_v2_REFUSALS]) {
  for (std::size_t i = 0; i < std::size(out); ++i) {
    out[i] = {};
    if (i >= refusals.size()) continue;
    set_text(out[i].topic, refusals[i].topic);
    set_text(out[i].reason, reason_name(refusals[i].reason));
    out[i].count = refusals[i].count;
    set_text(out[i].latest, refusals[i].latest + "; from " + refusals[i].from);
  }
}

}  // namespace

struct StatusReporter::Implementation {
  Implementation(Bus& b, Process process, std::function<void(const std::string&)> l)
      : bus(b), writer(b), log(std::move(l)) {
    status.process = process;
    status.pid = static_cast<std::int32_t>(getpid());
    status.state = c3rt_v2_SERVICE_STARTING;
    thread = std::thread([this] { run(); });
  }
  ~Implementation() {
    stop.store(true);
    signal.raise();
    thread.join();
    const std::lock_guard lock(mutex);
    if (status.state != c3rt_v2_SERVICE_FAILED) {
      status.state = c3rt_v2_SERVICE_STOPPING;
      text = "stopping";
    }
    publish();
  }

  void run() {
    become_helper_thread("status");
    for (int report = 0; !stop.load(); ++report) {
      if (report % kProblemsEvery == 0) look_at_peers();
      look_at_refusals();
      {
        const std::lock_guard lock(mutex);
        measure_rate();
        publish();
      }
      signal.wait(kPeriod_ns);
    }
  }

  void look_at_peers() {
    std::string found;
    for (const PeerProblem& problem : bus.problems()) {
      found += (found.empty() ? "" : "; ") + problem.text;
      tell(problem.text, problem.text);
    }
    const std::lock_guard lock(mutex);
    problems = found;
  }

  void look_at_refusals() {
    const std::vector<RefusedCount> refusals = bus.refusals();
    for (const RefusedCount& refused : refusals) {
      const std::string kind = "refused " + refused.topic + " (" + reason_name(refused.reason) +
                               ") from " + refused.from;
      tell(kind, kind + ": " + refused.latest);
    }
    const std::lock_guard lock(mutex);
    show(refusals, status.refused);
  }

  /// Once for each kind, however often it comes.
  void tell(const std::string& kind, const std::string& sentence) {
    if (log == nullptr || told.size() == kMostTold || !told.insert(kind).second) return;
    log(sentence);
  }

  void measure_rate() {
    const std::int64_t now_ns = rt::now_ns();
    const std::uint64_t count = compute.snapshot().count;
    const auto& [then_ns, then_count] = history[static_cast<std::size_t>(reports % kRateOver)];
    if (reports >= kRateOver) {
      status.rate_hz =
          static_cast<double>(count - then_count) / (static_cast<double>(now_ns - then_ns) * 1e-9);
    }
    history[static_cast<std::size_t>(reports % kRateOver)] = {now_ns, count};
    ++reports;
  }

  void publish() {
    set_text(status.text,
             problems.empty() ? text : (text.empty() ? problems : text + "; " + problems));
    status.wakeup_latency = to_wire(wakeup_latency.snapshot());
    status.compute = to_wire(compute.snapshot());
    for (int i = 0; i < names; ++i)
      status.counters[i] = counters[static_cast<std::size_t>(i)].load();
    writer.write(status, rt::now_ns());
  }

  Bus& bus;
  Writer<ServiceStatus> writer;
  rt::Statistics wakeup_latency, compute;
  std::array<std::atomic<std::uint64_t>, c3rt_v2_COUNTERS> counters{};

  std::mutex mutex;  // of what follows: set_state() and counter() against the thread
  ServiceStatus status{};
  std::string text, problems;
  std::function<void(const std::string&)> log;
  std::set<std::string> told;  // of the thread
  int names = 0;
  std::array<std::pair<std::int64_t, std::uint64_t>, kRateOver> history{};
  int reports = 0;

  std::atomic<bool> stop{false};
  Signal signal;
  std::thread thread;
};

StatusReporter::StatusReporter(Bus& bus, Process process,
                               std::function<void(const std::string&)> log)
    : implementation_(std::make_unique<Implementation>(bus, process, std::move(log))) {}
StatusReporter::~StatusReporter() = default;

void StatusReporter::set_state(c3rt_v2_ServiceState state, std::string_view text) {
  {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->status.state = state;
    implementation_->text = text;
  }
  implementation_->signal.raise();
}

std::atomic<std::uint64_t>& StatusReporter::counter(std::string_view name) {
  const std::lock_guard lock(implementation_->mutex);
  ServiceStatus& status = implementation_->status;
  for (int i = 0; i < implementation_->names; ++i) {
    if (name == status.counter_names[i])
      return implementation_->counters[static_cast<std::size_t>(i)];
  }
  if (implementation_->names == c3rt_v2_COUNTERS || name.size() >= sizeof status.counter_names[0]) {
    throw WireError("service/status has no room for the counter " + std::string(name));
  }
  const int i = implementation_->names++;
  set_text(status.counter_names[i], name);
  return implementation_->counters[static_cast<std::size_t>(i)];
}

rt::Statistics& StatusReporter::wakeup_latency() noexcept {
  return implementation_->wakeup_latency;
}
rt::Statistics& StatusReporter::compute() noexcept { return implementation_->compute; }

}  // namespace c3rt::wire
