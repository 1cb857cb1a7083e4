#pragma once
// The robot's modes as one function.
#include "plant_emulator/errors.hpp"

namespace c3rt::plant {

enum class Mode {
  kIdle,         // holds its position; waits for a command
  kMove,         // follows commanded torques, or motions
  kReflex,       // an error stopped it: brakes and holds until recovered
  kUserStopped,  // a person stopped it: brakes and holds until recovered
  kGuiding,      // a person leads it by the hand: it carries its own weight, nothing else
};

struct ModeState {
  Mode mode;
  Errors errors;  // of the reflex; kept until recovery
};

/// What happened in one cycle.
struct Events {
  bool command;           // a command that can be applied arrived
  Errors errors;          // found in this cycle
  bool stop;              // requested by a person
  bool recover;           // requested by a person
  bool guide = false;     // a person takes it by the hand, if it does not move
  bool release = false;   // and lets go
  bool finished = false;  // the motion that moved it has come to its end
};

/// A person's stop comes before everything, an error before motion, and only a person's recovery
/// ends either. A person may guide the arm whenever it does not move, out of an error, too, which
/// that does not end; an error ends guiding.
constexpr ModeState next(ModeState now, Events events) noexcept {
  if (events.stop) return {Mode::kUserStopped, now.errors};
  if (now.mode == Mode::kGuiding) {
    const Errors errors = now.errors | events.errors;
    if (events.errors == 0 && !events.release) return now;
    return {errors != 0 ? Mode::kReflex : Mode::kIdle, errors};
  }
  if (events.guide && now.mode != Mode::kMove && events.errors == 0)
    return {Mode::kGuiding, now.errors};
  if (now.mode == Mode::kReflex || now.mode == Mode::kUserStopped) {
    if (events.recover) return {Mode::kIdle, 0};
    return {now.mode, now.errors | events.errors};
  }
  if (events.errors != 0) return {Mode::kReflex, events.errors};
  if (events.finished) return {Mode::kIdle, 0};
  return {events.command ? Mode::kMove : now.mode, 0};
}

}  // namespace c3rt::plant
