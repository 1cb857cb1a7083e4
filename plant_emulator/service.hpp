#pragma once
// A robot's node on a bus, the emulated one or another: its mailboxes, its clients, its status.
// docs/reliability.md
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "idl/endpoint.hpp"
#include "plant_emulator/node.hpp"

namespace c3rt::plant {

/// What a fault of the plant can be about.
wire::FaultScope fault_scope(const Parameters& parameters);

/// One thread steps. Another one may serve clients: what they ask goes through a queue.
class Service {
 public:
  Service(wire::Bus& bus, wire::Endpoint& endpoint, RobotNode& node);

  /// Before the first step: what is now.
  void send(const RobotNode::Output& out, std::int64_t now_ns) noexcept;
  /// Obeys clients, takes the command and the motion that are in effect at `at_ns` (realtime: the
  /// newest), moves on by one cycle, and sends what is at now_ns. RT (realtime): no heap, no lock,
  /// no throw.
  void step(std::int64_t at_ns, std::int64_t now_ns) noexcept;
  /// Clients' requests and faults become orders; changes of the robot's mode become status and log.
  void serve(std::int64_t now_ns);

 private:
  void obey(const Order& order) noexcept;
  void show() noexcept;
  void serve_orders(std::int64_t now_ns);
  void tell_refused_motions();
  static std::string text_of(const Answered& answered);
  std::optional<wire::Answer> order(c3rt_v2_RequestVerb verb);
  std::optional<wire::Answer> stopped(bool late) const;
  std::optional<wire::Answer> recovered(bool late) const;
  std::string mode_text() const;
  std::string cause_text() const;

  wire::Endpoint& endpoint_;
  const bool realtime_;
  RobotNode& node_;
  wire::Inlet<wire::RobotCommand> commands_;
  wire::Inlet<wire::RobotMotion> motions_;
  wire::Reader<wire::RobotOrder> ordered_;
  wire::Outlet<wire::RobotState> states_;
  wire::Outlet<wire::Scene> scenes_;
  wire::Outlet<wire::RobotContact> contacts_;
  wire::RobotCommand command_{};
  wire::RobotMotion motion_{};
  Queue<Order> orders_;
  std::uint64_t count_ = 0;
  std::atomic<std::uint64_t>&cycles_, &lost_commands_, &saturated_, &reflexes_, &success_,
      &success_min_, &exposures_, &faults_, &refused_motions_;

  // of the thread that serves clients
  bool stop_pressed_ = false;
  std::uint32_t unanswered_ = 0;  // orders
  std::uint64_t told_refused_motions_ = 0;
  bool tells_refused_motions_ = false;

  // for it
  std::atomic<Mode> shown_mode_{Mode::kIdle};
  std::atomic<Errors> shown_errors_{0};
  struct {  // stored before the mode, which a reader loads first
    std::atomic<Error> error{};
    std::atomic<int> axis{0};
    std::atomic<double> value{0.0}, limit{0.0};
    std::atomic<const char*> unit{""};
  } shown_cause_;
  std::atomic<int> shown_moving_{0};
  std::atomic<bool> shown_standing_{false}, shown_waiting_{false};
};

}  // namespace c3rt::plant
