#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "controller/base/time.hpp"
#include "controller/base/words.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/shutdown_listener.hpp"

namespace c3rt::wire {

namespace {

// a blocked wait looks at the stop flag this often: a signal does not wake it
constexpr std::int64_t kSlice_ns = 50'000'000;
constexpr std::int64_t kJoinAgain_ns = 200'000'000;
constexpr int kNoTickFactor = 6;
constexpr int kTickDepth = 64;
constexpr int kArrivalPeriods = 2;     // without an arrival until the timer goes on
constexpr std::int64_t kJoining = -1;  // time of a Done that answers no tick

void merge(Sequences& newest, const Sequences& other) {
  for (int i = 0; i < c3rt_v2_TOPIC_COUNT; ++i) newest[i] = std::max(newest[i], other[i]);
}

std::string seconds(std::int64_t time_ns) { return base::words("%.6g s", base::seconds(time_ns)); }

std::uint32_t bit(Process process) { return 1U << static_cast<unsigned>(process); }

}  // namespace

struct Loop::Implementation {
  Implementation(Bus& b, const Settings& s)
      : bus(b), settings(s), shutdown(b, s.process), clock(s.period_ns) {
    if (bus.clock() == ClockMode::kRealtime) return;
    // nothing but a tick wakes this process: samples wait in their readers until they are promised
    ticks = std::make_unique<Reader<Tick>>(bus, kTickDepth, Wakes::kItself, settings.process);
    dones = std::make_unique<Writer<Done>>(bus);
    bus.hold_until_promised();
    next_due_ns = settings.phase_ns;
  }

  /// As the clock's wait(), for what arrives.
  rt::Wakeup wait_for_arrival() noexcept {
    while (!StopFlag::requested()) {
      const std::int64_t rest_ns = guard_ns - rt::now_ns();
      const bool arrived = settings.arrival->wait(rest_ns > 0 ? rest_ns : 0);
      // what comes in a burst is one arrival: limits per cycle hold per time, too
      while (rt::now_ns() < earliest_ns) settings.arrival->wait(earliest_ns - rt::now_ns());
      const std::int64_t woke_ns = rt::now_ns();
      if (!arrived && woke_ns < guard_ns) continue;  // a signal of the system
      const std::int64_t due_ns = arrived ? settings.arrival->raised_ns() : guard_ns;
      // how late the guard was is how long this thread did not run, however much has arrived since
      const std::int64_t late_ns = woke_ns - guard_ns;
      guard_ns = woke_ns + (arrived ? kArrivalPeriods : 1) * settings.period_ns;
      earliest_ns = woke_ns + settings.period_ns / 2;
      return {due_ns, woke_ns, woke_ns - due_ns, late_ns > 0 ? late_ns / settings.period_ns : 0};
    }
    const std::int64_t woke_ns = rt::now_ns();
    return {woke_ns, woke_ns, 0, 0};
  }

  bool wait_realtime(std::int64_t& now_ns) noexcept {
    const rt::Wakeup wakeup = settings.arrival != nullptr ? wait_for_arrival() : clock.wait();
    missed.fetch_add(static_cast<std::uint64_t>(wakeup.missed), std::memory_order_relaxed);
    const double latency_s = static_cast<double>(wakeup.latency_ns) * 1e-9;
    latency.add(latency_s);
    if (settings.wakeup_latency != nullptr) settings.wakeup_latency->add(latency_s);
    now_ns = wakeup.woke_ns;
    return !StopFlag::requested();
  }

  void answer() {
    Done done{};
    done.process = settings.process;
    done.next_due_ns = next_due_ns;
    bus.newest_written(done.newest_seq);
    dones->write(done, tick_ns);
  }

  bool wait_lockstep(std::int64_t& now_ns) {
    answer();
    std::int64_t heard_ns = rt::now_ns(), alive_ns = heard_ns, answered_ns = heard_ns;
    Tick tick{};
    while (!StopFlag::requested()) {
      while (ticks->take(tick)) {
        heard_ns = rt::now_ns();
        if ((tick.due & bit(settings.process)) == 0 || tick.header.time_ns < next_due_ns) continue;
        return take_part(tick, now_ns);
      }
      const std::int64_t real_ns = rt::now_ns();
      if (ticks->alive_writers() > 0) alive_ns = real_ns;
      if (joined && real_ns - alive_ns > settings.gone_timeout_ns) {
        failure = "the plant has been gone for " + seconds(settings.gone_timeout_ns) +
                  " (last tick " + seconds(tick_ns) + ")";
        return false;
      }
      const std::int64_t silence_ns =
          joined ? kNoTickFactor * settings.gone_timeout_ns : settings.join_timeout_ns;
      if (real_ns - heard_ns > silence_ns) {
        failure = "no tick from the plant for " + seconds(silence_ns);
        return false;
      }
      // the plant may have come after the first Done
      if (!joined && real_ns - answered_ns > kJoinAgain_ns) {
        answer();
        answered_ns = real_ns;
      }
      ticks->wait(kSlice_ns);
    }
    return false;
  }

  bool take_part(const Tick& tick, std::int64_t& now_ns) {
    std::string missing;
    const std::int64_t begin_ns = rt::now_ns();
    while (!bus.wait_for(tick.newest_seq, kSlice_ns, missing)) {
      if (StopFlag::requested()) return false;
      if (rt::now_ns() - begin_ns > settings.gone_timeout_ns) {
        failure = "the tick of " + seconds(tick.header.time_ns) + " promises a sample of " +
                  missing + " that did not arrive for " + seconds(settings.gone_timeout_ns);
        return false;
      }
    }
    joined = true;
    tick_ns = now_ns = tick.header.time_ns;
    const std::int64_t periods = (tick_ns - settings.phase_ns) / settings.period_ns + 1;
    next_due_ns = settings.phase_ns + periods * settings.period_ns;
    return true;
  }

  Bus& bus;
  Settings settings;
  ShutdownListener shutdown;
  rt::PeriodicClock clock;
  std::int64_t guard_ns = rt::now_ns() + settings.period_ns;  // then a cycle without an arrival
  std::int64_t earliest_ns = 0;                               // before that none
  rt::Statistics latency;
  std::atomic<std::uint64_t> missed{0};
  std::string failure;

  // lockstep
  std::unique_ptr<Reader<Tick>> ticks;
  std::unique_ptr<Writer<Done>> dones;
  bool joined = false;              // a tick has named this process
  std::int64_t tick_ns = kJoining;  // the one to be answered
  std::int64_t next_due_ns = 0;
};

Loop::Loop(Bus& bus, const Settings& settings)
    : implementation_(std::make_unique<Implementation>(bus, settings)) {}
Loop::~Loop() = default;

bool Loop::wait(std::int64_t& now_ns) {
  return implementation_->ticks == nullptr ? implementation_->wait_realtime(now_ns)
                                           : implementation_->wait_lockstep(now_ns);
}
const std::string& Loop::failure() const { return implementation_->failure; }
std::uint64_t Loop::missed_cycles() const noexcept { return implementation_->missed.load(); }
const rt::Statistics& Loop::wakeup_latency() const noexcept { return implementation_->latency; }

struct LockstepMaster::Implementation {
  Implementation(Bus& b, std::int64_t answer_timeout)
      : bus(b),
        answer_timeout_ns(answer_timeout),
        shutdown(b, c3rt_v2_PROCESS_PLANT),
        dones(b, kTickDepth, Wakes::kItself) {
    bus.hold_until_promised();
  }

  struct Participant {
    bool joined = false;
    std::int64_t next_due_ns = 0;
    bool answered = true;
  };

  /// Takes what has arrived: joins, and the answers to the tick of now_ns.
  void take_answers(std::int64_t now_ns) {
    Done done{};
    while (dones.take(done)) {
      const auto found = participants.find(done.process);
      if (found == participants.end()) continue;
      Participant& participant = found->second;
      const bool joining = !participant.joined;
      // a repeated join is older than the first tick, and an answer to an older tick was already
      // counted
      if (!joining && (participant.answered || done.header.time_ns != now_ns)) continue;
      participant.joined = participant.answered = true;
      participant.next_due_ns = done.next_due_ns;
      merge(newest, done.newest_seq);
    }
  }
  template <typename Predicate>
  std::string names(Predicate missing) const {
    std::string result;
    for (const auto& [process, participant] : participants) {
      if (missing(participant))
        result += (result.empty() ? "" : ", ") + std::string(process_name(process));
    }
    return result;
  }

  Bus& bus;
  std::int64_t answer_timeout_ns;
  ShutdownListener shutdown;
  Reader<Done> dones;
  std::map<Process, Writer<Tick>> ticks;  // one for each participant
  std::map<Process, Participant> participants;
  Sequences newest{};
  std::string failure;
};

LockstepMaster::LockstepMaster(Bus& bus, const std::vector<Process>& expected,
                               std::int64_t timeout_ns, std::int64_t answer_timeout_ns)
    : implementation_(std::make_unique<Implementation>(bus, answer_timeout_ns)) {
  Implementation& self = *implementation_;
  for (const Process process : expected) {
    self.participants[process] = {};
    self.ticks.try_emplace(process, bus, process);
  }
  const auto absent = [](const Implementation::Participant& participant) {
    return !participant.joined;
  };
  const std::int64_t deadline_ns = rt::now_ns() + timeout_ns;
  while (!StopFlag::requested()) {
    self.take_answers(kJoining);
    const std::string missing = self.names(absent);
    if (missing.empty()) return;
    const std::int64_t left_ns = deadline_ns - rt::now_ns();
    if (left_ns <= 0)
      throw WireError("did not join the lockstep run within " + seconds(timeout_ns) + ": " +
                      missing);
    self.dones.wait(std::min(left_ns, kSlice_ns));
  }
}

LockstepMaster::~LockstepMaster() = default;

bool LockstepMaster::advance(std::int64_t now_ns) {
  Implementation& self = *implementation_;
  if (StopFlag::requested() || !self.failure.empty()) return false;
  Tick tick{};
  self.bus.newest_written(tick.newest_seq);
  merge(tick.newest_seq, self.newest);
  for (auto& [process, participant] : self.participants) {
    participant.answered = participant.next_due_ns > now_ns;
    if (!participant.answered) tick.due |= bit(process);
  }
  // nobody acts: nobody needs to know
  if (tick.due == 0) return true;
  for (auto& [process, ticks] : self.ticks) {
    if ((tick.due & bit(process)) == 0 || ticks.write(tick, now_ns)) continue;
    self.failure = "could not send the tick of " + seconds(now_ns) + " to " + process_name(process);
    return false;
  }
  const auto silent = [](const Implementation::Participant& participant) {
    return !participant.answered;
  };
  const int expected = static_cast<int>(self.participants.size());
  const std::int64_t begin_ns = rt::now_ns();
  std::int64_t complete_ns = begin_ns;
  while (true) {
    self.take_answers(now_ns);
    const std::string missing = self.names(silent);
    if (missing.empty()) break;
    if (StopFlag::requested()) return false;
    const std::int64_t real_ns = rt::now_ns();
    if (self.dones.alive_writers() >= expected) complete_ns = real_ns;
    if (real_ns - complete_ns > self.answer_timeout_ns / 3) {
      self.failure = missing + " left the run before answering the tick of " + seconds(now_ns);
      return false;
    }
    if (real_ns - begin_ns > self.answer_timeout_ns) {
      self.failure = missing + " did not answer the tick of " + seconds(now_ns) + " for " +
                     seconds(self.answer_timeout_ns);
      return false;
    }
    self.dones.wait(kSlice_ns);
  }
  // what was written in answer is the plant's input of the next step
  std::string topic;
  if (!self.bus.wait_for(self.newest, self.answer_timeout_ns, topic)) {
    self.failure =
        "a sample of " + topic + " that was announced at " + seconds(now_ns) + " did not arrive";
    return false;
  }
  return true;
}

const std::string& LockstepMaster::failure() const { return implementation_->failure; }

}  // namespace c3rt::wire
