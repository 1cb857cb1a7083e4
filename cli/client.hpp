#pragma once
// A person's seat on the bus of a running instance: ask, tell, look.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cli/recording/samples.hpp"
#include "controller/task/request.hpp"
#include "idl/dds.hpp"

namespace c3rt::cli {

/// Which instance is meant.
struct Seat {
  std::uint32_t domain = 0;
  std::string dds_profile = "loopback";
};

/// The settings that fit the instance on this domain: its clock, its session, its profile; realtime
/// where none of this user runs.
wire::BusSettings bus_settings(const Seat& seat);

/// The process does its work, well or not so well.
bool in_service(const wire::ServiceStatus& status);
/// It has come up as far as it can: without a plant it waits for one.
bool has_come_up(const wire::ServiceStatus& status, bool without_plant);

/// Sends a request to each of these processes in turn and prints their replies. @return an exit
/// status
int request(const Seat& seat, const std::vector<wire::Process>& processes,
            c3rt_v2_RequestVerb verb);

/// Asks for a fault of a process, and for its answer. @return an exit status: 1 if it refuses
/// @throws UsageError for what the scenario that runs cannot do
int inject(const Seat& seat, wire::FaultInject fault);

/// Orders something of the robot itself, and awaits its answer. @return an exit status: 1 if it
/// refuses
/// @throws UsageError for what no robot could do
int order(const Seat& seat, const wire::RobotOrder& order);

/// Asks the planner for a new target, and for its answer. @return an exit status: 1 if it refuses
/// @throws UsageError for what no planner knows, or the scenario that runs cannot reach
int set_target(const Seat& seat, const task::Request& request);

/// The weights of the instance that runs and how far they may be changed, as a table. @return an
/// exit status: 1 if its scenario allows none
/// @throws UsageError where none of this user runs on the domain
int list_weights(const Seat& seat);
/// Asks the planner for other weights, and for its answer; none: the scenario's. @return an exit
/// status: 1 if it refuses
/// @throws UsageError for what the scenario that runs does not allow
int set_weights(const Seat& seat, const std::map<std::string, double>& weights);

}  // namespace c3rt::cli
