#pragma once
// The services of a scenario's processes, made within this one.
#include <cstdint>
#include <optional>

#include "config/scenario.hpp"
#include "controller/impedance/service.hpp"
#include "controller/impedance/servo.hpp"
#include "controller/planner/service.hpp"
#include "idl/endpoint.hpp"
#include "vision/scene_source.hpp"
#include "vision/service.hpp"

namespace c3rt::cli {

/// The impedance process: its cycle, and what goes on beside it.
struct Impedance {
  Impedance(wire::Bus& bus, wire::Endpoint& endpoint, const config::Scenario& scenario)
      : servo(bus, scenario.impedance, model::Arm(scenario.impedance.arm),
              endpoint.status().compute()),
        service(servo, endpoint) {}
  impedance::Servo servo;
  impedance::Service service;
};

inline void start(std::optional<planner::Service>& planner, wire::Bus& bus,
                  wire::Endpoint& endpoint, const config::Scenario& scenario, std::uint64_t seed) {
  planner.reset();
  planner.emplace(bus, endpoint, planner::seeded(scenario.planner, seed),
                  model::Arm(scenario.impedance.arm), scenario.timing.solve_time_s);
}

inline void start(std::optional<vision::Service>& vision, wire::Bus& bus, wire::Endpoint& endpoint,
                  const config::Scenario& scenario, std::uint64_t seed) {
  vision.reset();
  vision.emplace(
      bus, endpoint, scenario.vision, vision::starts_of(scenario.plant.world),
      scenario.timing.vision_latency_s,
      vision::make_scene_source(bus, endpoint, scenario.plant.world, scenario.vision, seed));
}

}  // namespace c3rt::cli
