#pragma once
// How well the end effector follows its plans.
#include "cli/report/series.hpp"

namespace c3rt::cli {

/// |p_WE − p_WE_desired| of the commands that track a plan, sample by sample.
struct TrackingError {
  LongRows<double> time;   // since the recording's start [s]
  LongRows<double> error;  // [m]
};

struct TrackingErrors {
  TrackingError task;      // plans of phase roll and return, and those that were not recorded
  TrackingError approach;  // all others: the way to the first object and from one object to another
};

/// Without the first second of tracking.
TrackingErrors tracking_errors(const Series& series);

}  // namespace c3rt::cli
