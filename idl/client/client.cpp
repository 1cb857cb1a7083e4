#include "idl/client/client.hpp"

#include <algorithm>
#include <random>

#include "controller/base/words.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/client/profiles.hpp"
#include "idl/convert.hpp"
#include "idl/process.hpp"

namespace c3rt::client {
namespace {

constexpr std::uint32_t kLastDomain = 230;  // a domain has ports for no later one
constexpr double kDiscovery_s = 3.0;        // until a peer must have been found
constexpr double kOthers_s = 0.2;           // in which those are found that come after the first
constexpr int kRoom = 64;                   // for answers and statuses

/// Not the number of another client that began in the same moment.
std::uint64_t first_request() {
  std::random_device device;
  return ((std::uint64_t{device()} << 31U) ^ device()) | 1U;
}

std::string place(std::uint32_t domain) { return "domain " + std::to_string(domain); }

}  // namespace

namespace detail {

bool goes_on(std::int64_t end_ns) noexcept {
  return !wire::StopFlag::requested() && rt::now_ns() < end_ns;
}
std::int64_t after(double seconds) noexcept {
  return rt::now_ns() + static_cast<std::int64_t>(seconds * 1e9);
}

}  // namespace detail

wire::BusSettings bus_settings(std::uint32_t domain, const std::string& profile) {
  if (domain > kLastDomain) {
    throw std::invalid_argument("domain: expected 0 to " + std::to_string(kLastDomain) + ", got " +
                                std::to_string(domain));
  }
  wire::BusSettings settings;
  settings.domain = domain;
  settings.profile_uri = profile_uri(profile);
  settings.shares_clock = false;  // the service may be on another host
  return settings;
}

Services listen(wire::Bus& bus, double seconds) {
  wire::Reader<wire::ServiceStatus> reader(bus, kRoom);
  Services services;
  const std::uint64_t session = bus.session_id();
  const std::int64_t end_ns = detail::after(seconds);
  while (true) {
    wire::ServiceStatus status{};
    while (reader.take(status)) {
      const auto process = static_cast<std::size_t>(status.process);
      // what an older instance left behind is no word of this one; who plays a process may know
      // none
      const std::uint64_t theirs = status.header.session_id;
      const bool ours = session == 0 || theirs == 0 || theirs == session;
      if (ours && process < services.size()) services[process] = status;
    }
    const auto heard = std::count_if(services.begin(), services.end(),
                                     [](const auto& s) { return s.has_value(); });
    if (heard == 4 || !detail::goes_on(end_ns)) return services;
    bus.wait_for_data(std::min(detail::kSlice_ns, end_ns - rt::now_ns()));
  }
}

Client::Client(const wire::BusSettings& settings)
    : domain_(settings.domain),
      bus_(settings),
      replies_(bus_, kRoom, wire::Wakes::kItself),
      next_id_(first_request()) {}

std::int64_t Client::now_ns() noexcept { return rt::now_ns(); }

void Client::fail_unsent(const char* topic) const {
  throw wire::WireError(std::string(topic) + " could not be sent on " + place(domain_));
}

void Client::fail_silent(const char* topic, double seconds) const {
  throw NoAnswer(
      base::words("%s: nothing has come for %g s on %s: c3rt status tells what runs, "
                  "c3rt hz %s whether it is written",
                  topic, seconds, place(domain_).c_str(), topic));
}

void Client::await_listeners(const wire::WriterBase& writer, const char* topic) {
  const auto found = [&] { return writer.matched_readers() > 0 && replies_.matched_writers() > 0; };
  if (found()) return;
  for (const std::int64_t end_ns = detail::after(kDiscovery_s); !found();) {
    if (!detail::goes_on(end_ns))
      throw NobodyListens("nobody listens to " + std::string(topic) + " on " + place(domain_));
    replies_.wait(detail::kSlice_ns);
  }
  for (const std::int64_t end_ns = detail::after(kOthers_s); detail::goes_on(end_ns);)
    replies_.wait(detail::kSlice_ns);
}

std::vector<std::optional<Reply>> Client::await_replies(std::uint64_t first_id, std::size_t count,
                                                        double seconds) {
  std::vector<std::optional<Reply>> replies(count);
  const std::int64_t end_ns = detail::after(seconds);
  while (true) {
    wire::ServiceReply reply{};
    while (replies_.take(reply)) {
      const std::uint64_t i = reply.request_id - first_id;
      if (i < count) replies[i] = Reply{reply.process, reply.ok, reply.text};
    }
    const bool complete = std::all_of(replies.begin(), replies.end(),
                                      [](const auto& answer) { return answer.has_value(); });
    if (complete || !detail::goes_on(end_ns)) return replies;
    replies_.wait(std::min(detail::kSlice_ns, end_ns - rt::now_ns()));
  }
}

std::vector<Reply> Client::all(const std::vector<std::optional<Reply>>& replies,
                               const std::vector<wire::Process>& asked, double seconds) const {
  std::vector<Reply> answers;
  std::string missing;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const std::string name = wire::process_name(asked[i]);
    if (!replies[i]) {
      missing += (missing.empty() ? "" : ", ") + name;
    } else if (!replies[i]->ok) {
      throw Refused(name + ": " + replies[i]->text);
    } else {
      answers.push_back(*replies[i]);
    }
  }
  if (missing.empty()) return answers;
  throw NoAnswer(base::words("%s did not answer for %g s on %s: c3rt status tells what runs",
                             missing.c_str(), seconds, place(domain_).c_str()));
}

Reply Client::target(const std::string& kind, const std::vector<Parameter>& parameters,
                     double seconds) {
  task::Request request{kind, {}};
  for (const Parameter& parameter : parameters)
    request.parameters.push_back({parameter.name, parameter.values, parameter.word});
  return all(ask(std::vector{wire::task_target(request)}, seconds), {c3rt_v2_PROCESS_PLANNER},
             seconds)
      .front();
}

Reply Client::weights(const std::map<std::string, double>& weights, double seconds) {
  return all(ask(std::vector{wire::planner_weights(weights)}, seconds), {c3rt_v2_PROCESS_PLANNER},
             seconds)
      .front();
}

std::vector<Reply> Client::stop(double seconds) { return request(c3rt_v2_REQUEST_STOP, seconds); }

std::vector<Reply> Client::recover(double seconds) {
  return request(c3rt_v2_REQUEST_RECOVER, seconds);
}

std::vector<Reply> Client::request(c3rt_v2_RequestVerb verb, double seconds) {
  const std::vector<wire::Process> asked = {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE,
                                            c3rt_v2_PROCESS_PLANNER};
  std::vector<wire::ServiceRequest> samples(asked.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    samples[i].process = asked[i];
    samples[i].verb = verb;
  }
  return all(ask(samples, seconds), asked, seconds);
}

Reply Client::shutdown(wire::Process process, double seconds) {
  wire::ServiceRequest sample{};
  sample.process = process;
  sample.verb = c3rt_v2_REQUEST_SHUTDOWN;
  return all(ask(std::vector{sample}, seconds), {process}, seconds).front();
}

Reply Client::fault(const wire::FaultInject& fault, double seconds) {
  return all(ask(std::vector{fault}, seconds), {fault.process}, seconds).front();
}

Reply Client::guide(std::uint32_t free_axes, bool free_elbow, double seconds) {
  wire::RobotOrder sample{};
  sample.kind = c3rt_v2_ORDER_GUIDING;
  sample.engaged = true;
  sample.free_axes = free_axes;
  sample.free_elbow = free_elbow;
  return order(sample, seconds);
}

Reply Client::release(double seconds) {
  wire::RobotOrder sample{};
  sample.kind = c3rt_v2_ORDER_GUIDING;
  return order(sample, seconds);
}

Reply Client::user_stop(bool pressed, double seconds) {
  wire::RobotOrder sample{};
  sample.kind = c3rt_v2_ORDER_USER_STOP;
  sample.engaged = pressed;
  return order(sample, seconds);
}

Reply Client::thresholds(const c3rt_v2_ContactThresholds& nominal,
                         const c3rt_v2_ContactThresholds& acceleration, double seconds) {
  wire::RobotOrder sample{};
  sample.kind = c3rt_v2_ORDER_THRESHOLDS;
  sample.nominal = nominal;
  sample.acceleration = acceleration;
  return order(sample, seconds);
}

Reply Client::push(const std::array<double, 3>& force_W, double duration, double seconds) {
  wire::RobotOrder sample{};
  sample.kind = c3rt_v2_ORDER_PUSH;
  std::copy(force_W.begin(), force_W.end(), sample.force_W_n);
  sample.duration_s = duration;
  return order(sample, seconds);
}

Reply Client::order(const wire::RobotOrder& order, double seconds) {
  return all(ask(std::vector{order}, seconds), {c3rt_v2_PROCESS_PLANT}, seconds).front();
}

}  // namespace c3rt::client
