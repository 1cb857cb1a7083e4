#pragma once
// The last plan, for the polish of the next.
#include <cmath>

#include "controller/c3/solver.hpp"

namespace c3rt::c3 {

/// Hands a solver's plan on to its next solve, as many stages on as it is older then. It knows none
/// where nothing was polished, and none of which less than half is left: polish makes little of
/// worth of such a plan.
class KnownPlan {
 public:
  /// @param period between two solves [s]
  /// @param step of a stage [s]
  KnownPlan(double period, double step, int N)
      : stages_(static_cast<int>(std::lround(period / step))), lasts_(2 * stages_ <= N) {}

  void forget() noexcept { is_known_ = false; }
  /// No heap but the first time.
  void keep(const Solution& solution) {
    is_known_ = lasts_ && solution.status != SolveStatus::kFailed &&
                solution.polish.status != PolishStatus::kOff;
    if (is_known_) shift_plan(solution, stages_, plan_);
  }
  /// The plan alone, or none.
  const Start* start() const noexcept { return is_known_ ? &plan_ : nullptr; }
  /// That of start() beside copies and duals: it replaces the plan that `start` has.
  static void put(const Start* plan, Start& start) {
    if (plan != nullptr) {
      start.u = plan->u;
      start.modes = plan->modes;
    } else {
      start.u.resize(0, 0);
      start.modes.resize(0, 0);
    }
  }

 private:
  int stages_;
  bool lasts_, is_known_ = false;
  Start plan_;
};

}  // namespace c3rt::c3
