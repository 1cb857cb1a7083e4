#pragma once
// One process of a scenario alone, in simulated time and without DDS: it is given samples as if
// the others wrote them, and its answers are taken.
#include <cstdint>
#include <map>
#include <memory>
#include <type_traits>

#include "config/scenario.hpp"
#include "idl/dds.hpp"
#include "idl/exchange.hpp"

namespace c3rt::cli::replay {

class Alone {
 public:
  /// @param process planner, vision or impedance
  /// @param session that its samples, and those that it is given, are of
  /// @throws what its node throws for a scenario that it cannot use
  Alone(const config::Scenario& scenario, wire::Process process, std::uint64_t seed,
        std::uint64_t session);
  ~Alone();
  Alone(const Alone&) = delete;
  Alone& operator=(const Alone&) = delete;

  /// There at once, as it is, for the process to take in its next step.
  template <typename T>
  void give(const T& sample) {
    exchange_->put(wire::topic<T>(), &sample, sender_of(wire::topic<T>()), sample.header.seq);
  }
  /// What is due in one of its periods.
  void step(std::int64_t now_ns);
  std::int64_t period_ns() const;

  /// Of who reads what it answers.
  wire::Bus& ears() { return ears_; }

 private:
  struct Work;
  wire::Sender sender_of(const wire::Topic& topic);

  const std::shared_ptr<wire::Exchange> exchange_;
  wire::Bus ears_;
  std::unique_ptr<Work> work_;
  std::map<const char*, wire::Sender> senders_;  // of topics with one writer, by name
};

}  // namespace c3rt::cli::replay
