#include "idl/endpoint.hpp"

#include <algorithm>

namespace c3rt::wire {
namespace {

constexpr int kDepth = 64;  // requests that may wait

}  // namespace

Endpoint::Endpoint(Bus& bus, Process process, const FaultScope& scope, const Log& log, Wakes wakes)
    : process_(process),
      scope_(scope),
      log_(log),
      status_(bus, process,
              log ? std::function<void(const std::string&)>(
                        [log](const std::string& sentence) { log(true, sentence); })
                  : nullptr),
      requests_(bus, kDepth, wakes),
      faults_(bus, kDepth, wakes),
      replies_(bus, process) {}

void Endpoint::serve_requests(std::int64_t now_ns, const Obey& obey, std::uint64_t cycle) {
  replies_.answer_refused(requests_, now_ns);
  ServiceRequest request{};
  while (requests_.take(request)) {
    if (request.process != process_ || request.verb == c3rt_v2_REQUEST_SHUTDOWN) continue;
    if (pending_.size() == kMostPending) {
      replies_.answer(request.request_id, false, "too many requests wait for an answer", now_ns);
    } else if (const std::optional<Answer> answer = obey(request.verb)) {
      replies_.answer(request.request_id, answer->ok, answer->text, now_ns);
    } else {
      pending_.push_back({request.request_id, request.verb, cycle});
    }
  }
}

void Endpoint::answer_pending(std::int64_t now_ns, std::uint64_t cycle, const Judge& judge) {
  const auto answered = [&](const Pending& pending) {
    if (cycle < pending.cycle + kCyclesToObey) return false;
    const bool late = cycle >= pending.cycle + kAnswerWithinCycles;
    const std::optional<Answer> answer = judge(pending.verb, late);
    if (answer) replies_.answer(pending.request_id, answer->ok, answer->text, now_ns);
    return answer.has_value();
  };
  pending_.erase(std::remove_if(pending_.begin(), pending_.end(), answered), pending_.end());
}

void Endpoint::serve_faults(std::int64_t now_ns, const Inject& inject) {
  replies_.answer_refused(faults_, now_ns);
  FaultInject fault{};
  while (faults_.take(fault)) {
    if (fault.process != process_) continue;
    std::string refused = refusal(fault, scope_);
    if (refused.empty()) refused = inject(fault);
    const bool acts = refused.empty();
    const std::string said = acts ? describe(fault) : "refused: " + refused;
    replies_.answer(fault.request_id, acts, said, now_ns);
    if (log_) log_(!acts, "fault " + said);
  }
}

bool Endpoint::say(c3rt_v2_ServiceState state, const std::string& text) {
  if (said_ && state == state_ && text == text_) return false;
  said_ = true;
  state_ = state;
  text_ = text;
  status_.set_state(state, text);
  return true;
}

}  // namespace c3rt::wire
