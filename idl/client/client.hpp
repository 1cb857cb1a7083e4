#pragma once
// What a program of one's own reads of a running service, and what it asks of it (docs/clients.md).
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "idl/dds.hpp"

#ifdef _GLIBCXX_DEBUG
#error "c3rt: expected the usual std::vector: undefine _GLIBCXX_DEBUG (_GLIBCXX_ASSERTIONS is fine)"
#endif

namespace c3rt::client {

/// A process has answered that it does not do what it was asked; the text says why.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Nobody has answered, or nothing has come, for as long as was given.
class NoAnswer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Nobody reads the topic on which was to be asked.
class NobodyListens : public NoAnswer {
 public:
  using NoAnswer::NoAnswer;
};

constexpr double kPatience_s = 5.0;  // until an answer must have come

/// Of a client that knows neither clock nor session of the service: it reads both clocks' samples.
/// @param profile loopback, lan, secure, secure_lan, or a DDS profile's file
/// @throws std::invalid_argument for a domain beyond 230, wire::ProfileError for an unknown profile
wire::BusSettings bus_settings(std::uint32_t domain, const std::string& profile);

/// What each process says of itself, by its number.
using Services = std::array<std::optional<wire::ServiceStatus>, wire::kProcessCount>;

/// What the processes of the bus's session say within the time given [s]; returns early once four
/// have spoken.
Services listen(wire::Bus& bus, double seconds);

/// What a process has answered.
struct Reply {
  wire::Process process;
  bool ok;
  std::string text;
};

/// Of a task, by the keys of a scenario's section `task`: {"radius_m", {0.08}}, {"between", {},
/// "hold"}.
struct Parameter {
  std::string name;
  std::vector<double> values;  // one of a number, all of a list, row after row of a list of lists;
                               // 0 or 1 of a truth value
  std::string word = {};       // of what names one of several
};

/// Samples of a topic that the rules of docs/clients.md let in. For one thread.
template <typename T>
class Reader {
 public:
  /// @param depth samples that are kept until they are taken. 1: the latest value; more: a queue
  explicit Reader(wire::Bus& bus, int depth = 1) : reader_(bus, depth, wire::Wakes::kItself) {}

  /// The next one in order; false, and `out` untouched, if there is none.
  bool take(T& out) noexcept { return reader_.take(out); }
  /// The same, waited for. @return false after that time [s]
  bool wait(T& out, double seconds);
  wire::ReaderCounters counters() const noexcept { return reader_.counters(); }

 private:
  wire::Reader<T> reader_;
};

/// Takes part in a service's bus as a client, from one thread. One in a program: Cyclone DDS 0.10
/// must not delete a participant while another one of the same program is finding its peers.
/// SIGINT and SIGTERM end its waiting where the program has a wire::StopFlag.
class Client {
 public:
  /// Of the service that `c3rt status` tells of. No environment variable is needed.
  /// @throws as bus_settings(); wire::WireError if the domain cannot be joined
  explicit Client(std::uint32_t domain = 0, const std::string& profile = "loopback")
      : Client(bus_settings(domain, profile)) {}
  explicit Client(const wire::BusSettings& settings);

  wire::Bus& bus() noexcept { return bus_; }  // for a Reader of one's own

  /// The newest sample of a topic that was not given out before, waited for.
  /// @throws NoAnswer after that time [s]
  template <typename T>
  T newest(double seconds = kPatience_s);

  /// What each process says of itself. Waits for all four, and not longer than that [s].
  Services status(double seconds = 2.0) { return listen(bus_, seconds); }

  // What is asked is sent, and the answer awaited. @throws Refused with the process's reason,
  // NoAnswer after that time [s], wire::WireError if it could not be sent

  /// Gives the planner a task. "hold" ends all motion, "scenario" gives the scenario's own back.
  /// @throws std::invalid_argument where a sample has no room for it
  Reply target(const std::string& kind, const std::vector<Parameter>& parameters = {},
               double seconds = kPatience_s);
  /// Gives Algorithm 1 other weights, by their keys below planner.weights of a scenario that allows
  /// it ("roll.Q.ball_xy"); none: all are the scenario's again.
  /// @throws std::invalid_argument where a sample has no room for them
  Reply weights(const std::map<std::string, double>& weights, double seconds = kPatience_s);
  std::vector<Reply> stop(double seconds = kPatience_s);  // until recover()
  /// Ends a reflex or a stop, and awaits that the robot moves again.
  std::vector<Reply> recover(double seconds = kPatience_s);
  Reply shutdown(wire::Process process, double seconds = kPatience_s);
  Reply fault(const wire::FaultInject& fault, double seconds = kPatience_s);

  // What a person does to the robot itself, answered once it has obeyed (docs/reliability.md)

  /// Takes the arm by the hand. @param free_axes of W that it can be led along and about: bits x,
  /// y, z, roll, pitch, yaw. @param free_elbow and joint 3
  Reply guide(std::uint32_t free_axes = 63, bool free_elbow = true, double seconds = kPatience_s);
  Reply release(double seconds = kPatience_s);  // and lets go of it
  /// Presses the robot's stop button, or releases it; then recover() ends the stop.
  Reply user_stop(bool pressed, double seconds = kPatience_s);
  /// Sets from which torque or force on a contact is told, and from which on a collision stops the
  /// robot; while nothing moves it. @param nominal, acceleration: while no joint accelerates, or
  /// one
  Reply thresholds(const c3rt_v2_ContactThresholds& nominal,
                   const c3rt_v2_ContactThresholds& acceleration, double seconds = kPatience_s);
  /// Pushes the end effector's centre. @param force_W [N] @param duration [s]
  Reply push(const std::array<double, 3>& force_W, double duration, double seconds = kPatience_s);
  Reply order(const wire::RobotOrder& order, double seconds = kPatience_s);

  /// Asks all before one has to answer: of TaskTarget, PlannerWeights, ServiceRequest, FaultInject
  /// or RobotOrder.
  /// @return an answer for each sample; nothing of who did not answer in time
  template <typename T>
  std::vector<std::optional<Reply>> ask(std::vector<T> samples, double seconds);

 private:
  std::vector<Reply> request(c3rt_v2_RequestVerb verb, double seconds);
  /// @throws Refused, NoAnswer
  std::vector<Reply> all(const std::vector<std::optional<Reply>>& replies,
                         const std::vector<wire::Process>& asked, double seconds) const;
  void await_listeners(const wire::WriterBase& writer, const char* topic);
  std::vector<std::optional<Reply>> await_replies(std::uint64_t first_id, std::size_t count,
                                                  double seconds);
  static std::int64_t now_ns() noexcept;
  [[noreturn]] void fail_unsent(const char* topic) const;
  [[noreturn]] void fail_silent(const char* topic, double seconds) const;

  template <typename Endpoint>
  Endpoint& kept(std::shared_ptr<void>& place) {
    if (place == nullptr) place = std::make_shared<Endpoint>(bus_);
    return *static_cast<Endpoint*>(place.get());
  }

  const std::uint32_t domain_;
  wire::Bus bus_;
  wire::Reader<wire::ServiceReply> replies_;
  // one for each topic, made when it is first wanted
  std::array<std::shared_ptr<void>, wire::table::kCount> readers_, writers_;
  std::uint64_t next_id_;
};

namespace detail {
/// Whether the time is not yet over, and no stop was requested.
bool goes_on(std::int64_t end_ns) noexcept;
std::int64_t after(double seconds) noexcept;    // of CLOCK_MONOTONIC
constexpr std::int64_t kSlice_ns = 50'000'000;  // a blocked wait looks at signals this often
}  // namespace detail

template <typename T>
bool Reader<T>::wait(T& out, double seconds) {
  const std::int64_t end_ns = detail::after(seconds);
  while (!take(out)) {
    if (!detail::goes_on(end_ns)) return false;
    reader_.wait(std::min(detail::kSlice_ns, end_ns - detail::after(0.0)));
  }
  return true;
}

template <typename T>
T Client::newest(double seconds) {
  auto& reader = kept<Reader<T>>(readers_[wire::table::PlaceOf<T>::value]);
  T sample{};
  if (!reader.wait(sample, seconds)) fail_silent(wire::topic<T>().name, seconds);
  while (reader.take(sample)) continue;
  return sample;
}

template <typename T>
std::vector<std::optional<Reply>> Client::ask(std::vector<T> samples, double seconds) {
  static_assert(wire::kAnswered<T>, "a target, a request, a fault or an order");
  auto& writer = kept<wire::Writer<T>>(writers_[wire::table::PlaceOf<T>::value]);
  await_listeners(writer, wire::topic<T>().name);
  const std::uint64_t first_id = next_id_;
  for (T& sample : samples) {
    sample.request_id = next_id_++;
    if (!writer.write(sample, now_ns())) fail_unsent(wire::topic<T>().name);
  }
  return await_replies(first_id, samples.size(), seconds);
}

}  // namespace c3rt::client
