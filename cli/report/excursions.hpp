#pragma once
// When an object was out of its band, for how long and how far; what became of each push.
#include <limits>
#include <optional>
#include <vector>

#include "cli/report/series.hpp"
#include "controller/task/task.hpp"
#include "plant_emulator/pushes.hpp"

namespace c3rt::cli {

/// A stretch of time in which the worst object was farther than 2 cm from where it should be.
struct Excursion {
  double start;     // since the recording's start [s]
  double duration;  // until it was back, or until the recording's end [s]
  double largest;   // distance [m]
  bool returned;    // before the recording's end
};

/// A push that fell into the time that is judged.
struct PushFigures {
  plant::Push push;
  double out_of_band;  // in all, until the next push or the recording's end [s]
  double largest;      // distance to the path in that time [m]
  bool returned;       // in the band at the end of that time
};

struct ExcursionFigures {
  std::vector<Excursion> excursions;                          // in order of time
  double longest = std::numeric_limits<double>::quiet_NaN();  // 0 if there was none [s]
  double largest = std::numeric_limits<double>::quiet_NaN();  // [m]
  std::optional<bool> ended_in_band;                          // over the whole last second
  std::vector<PushFigures> pushes;
};

/// From `judged_from` seconds after the task began; nothing where that is not a number.
/// @param pushes in order of time, which counts from the first row of the scene
ExcursionFigures excursion_figures(const Series& series, const task::Task& task, double judged_from,
                                   const std::vector<plant::Push>& pushes);

}  // namespace c3rt::cli
