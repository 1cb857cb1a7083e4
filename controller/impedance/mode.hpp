#pragma once
// When the controller waits, holds, tracks and stops.

namespace c3rt::impedance {

enum class Mode {
  kWait,   // no robot state was ever seen: nothing is commanded
  kHold,   // no plan to follow: stays where it was, damped
  kTrack,  // follows the plan
  kStop,   // the robot state cannot be trusted, or a person said so: damps until recovered
};

struct Health {
  bool state_seen;   // a robot state has arrived
  bool state_good;   // it is fresh, finite and within limits
  bool robot_moves;  // the robot takes commands (no reflex, not stopped by its user)
  bool plan_good;    // received, of this session, effective, valid, finite
  bool stop;         // requested
  bool recover;      // requested
};

/// Losing the state or a limit is final until a person says "recover"; losing the plan is not.
///
///   WAIT ──state──▶ HOLD ◀──plan──▶ TRACK
///                     │               │
///                     └───▶ STOP ◀────┘
///                            └──recover, with a good state──▶ HOLD or TRACK
constexpr Mode next(Mode mode, const Health& health) noexcept {
  if (mode == Mode::kWait && !health.state_seen) return Mode::kWait;
  if (health.stop || !health.state_good) return Mode::kStop;
  if (mode == Mode::kStop && !health.recover) return Mode::kStop;
  return health.plan_good && health.robot_moves ? Mode::kTrack : Mode::kHold;
}

}  // namespace c3rt::impedance
