#pragma once
// What clients ask of a process and what it says of itself: requests, faults, answers and status,
// the same way in every process.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "idl/faults.hpp"
#include "idl/process.hpp"
#include "idl/replies.hpp"

namespace c3rt::wire {

struct Answer {
  bool ok;
  std::string text;
};

/// A request is handed over during one cycle and surely obeyed in the next.
constexpr std::uint64_t kCyclesToObey = 2;
/// A request that an arm at 1 kHz obeys is answered when it is known to have worked. If it has not
/// after so many cycles, the answer says why not.
constexpr std::uint64_t kAnswerWithinCycles = 3000;
/// So many requests may wait for their answers; more are refused.
constexpr std::size_t kMostPending = 64;
/// Recovered is what has gone on for so many cycles.
constexpr int kSteadyCycles = 400;

/// For the one thread that serves a process's clients. REQUEST_SHUTDOWN is not seen here:
/// ShutdownListener obeys and answers it.
class Endpoint {
 public:
  /// @param attention false: in the ordinary course of things
  using Log = std::function<void(bool attention, const std::string& sentence)>;
  /// @param scope what the scenario has that a fault can be about
  /// @param wakes kItself: for a thread of its own that calls wait()
  Endpoint(Bus& bus, Process process, const FaultScope& scope, const Log& log,
           Wakes wakes = Wakes::kBus);

  /// What the process does about a request, and the answer; none: answer_pending() gives it.
  using Obey = std::function<std::optional<Answer>(c3rt_v2_RequestVerb)>;
  /// Takes what has come since the last call. Requests of others are left alone, those that a
  /// reader refused are answered with the reason.
  /// @param cycle of the process's loop
  void serve_requests(std::int64_t now_ns, const Obey& obey, std::uint64_t cycle = 0);

  /// Whether the process has done what was asked; none: not known yet. `late`: there must be one.
  using Judge = std::function<std::optional<Answer>(c3rt_v2_RequestVerb, bool late)>;
  /// Answers requests that were obeyed long enough ago to be judged.
  void answer_pending(std::int64_t now_ns, std::uint64_t cycle, const Judge& judge);

  /// Lets a fault act. @return why it cannot; empty: it acts
  using Inject = std::function<std::string(const FaultInject&)>;
  /// The same for faults: one that this process has not, or that no world could do, is answered and
  /// never handed on.
  void serve_faults(std::int64_t now_ns, const Inject& inject);

  /// The process's state and a sentence about it. @return whether either is new
  bool say(c3rt_v2_ServiceState state, const std::string& text);
  /// A sentence for the log alone.
  void tell(bool attention, const std::string& sentence) const {
    if (log_) log_(attention, sentence);
  }

  StatusReporter& status() noexcept { return status_; }
  Replies& replies() noexcept { return replies_; }
  /// Sleeps until a request arrives or the time is over (Wakes::kItself).
  void wait(std::int64_t timeout_ns) { requests_.wait(timeout_ns); }

 private:
  struct Pending {
    std::uint64_t request_id;
    c3rt_v2_RequestVerb verb;
    std::uint64_t cycle;  // when it was taken
  };

  const Process process_;
  const FaultScope scope_;
  const Log log_;
  StatusReporter status_;
  Reader<ServiceRequest> requests_;
  Reader<FaultInject> faults_;
  Replies replies_;
  std::vector<Pending> pending_;
  bool said_ = false;
  c3rt_v2_ServiceState state_ = c3rt_v2_SERVICE_STARTING;
  std::string text_;
};

}  // namespace c3rt::wire
