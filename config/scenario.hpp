#pragma once
// One file for all processes: which task, plant, controller, planner, vision and timing.
#include <optional>
#include <string>
#include <vector>

#include "config/section.hpp"
#include "config/service.hpp"
#include "controller/impedance/parameters.hpp"
#include "controller/planner/parameters.hpp"
#include "controller/task/circle.hpp"
#include "plant_emulator/parameters.hpp"
#include "vision/parameters.hpp"

namespace c3rt::config {

struct Task {
  task::Task motion = task::Circle{};  // what the bodies are to do
  int loops;  // the run ends after this many rounds of circle or path; 1 of a line, when all
              // objects have arrived
  double duration_s;  // or after this long
};

/// A bound on one value of the report; the run's criteria are met if all are.
struct Criterion {
  std::string
      name;  // loops_completed, max_loop_time_s, in_band_2cm, in_band_1cm, tracking_error_p95_m, …
  std::optional<double> min, max;
};

/// Lockstep takes these from here instead of from the machine.
struct Timing {
  double solve_time_s;      // of the planner
  double vision_latency_s;  // exposure to estimate
};

struct Scenario {
  std::string name, description;
  Task task;
  std::vector<Criterion> criteria;
  Timing timing;
  Service service;
  plant::Parameters plant;
  impedance::Parameters impedance;
  planner::Parameters planner;
  vision::Parameters vision;
};

/// Reads and checks the whole file, whoever asks: a mistake in any section stops every process.
/// @throws ConfigError naming file, line, key and what was expected
Scenario load_scenario(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same of a file that has been read.
Scenario read_scenario(Section root);

}  // namespace c3rt::config
