#pragma once
// Which task a strategy follows, since when, and how far it is: the scenario's, or a client's in
// its place.
#include <cmath>
#include <optional>

#include "controller/planner/input.hpp"
#include "controller/planner/parameters.hpp"

namespace c3rt::planner {

class TaskAtHand {
 public:
  explicit TaskAtHand(const task::Task& scenarios) : own_{scenarios} {}

  /// Another task of a client begins anew; the scenario's goes on where it was left.
  void take(const Target& target) {
    const auto* task = std::get_if<task::Task>(&target);
    if (task == nullptr) {
      clients_.reset();
    } else if (!clients_ || !clients_->task.is(*task)) {
      clients_ = Followed{*task};
    }
  }
  /// C3 works at it: from the first time on its clock runs.
  void begin(double now) {
    if (at_hand().since >= 0.0) return;
    at_hand().since = now;
    if (std::isnan(at_hand().state.since)) at_hand().state.since = now;
  }
  /// What is reached, of a task with goals. @param scene as it is seen now
  void advance(double now, const scene::Scene& scene) {
    at_hand().task.advance(now, scene, at_hand().state);
  }

  bool begun() const { return at_hand().since >= 0.0; }

  const task::Task& task() const { return at_hand().task; }
  bool clients() const { return clients_.has_value(); }
  /// Since it began; 0 before [s].
  double elapsed(double now) const { return at_hand().since < 0.0 ? 0.0 : now - at_hand().since; }
  std::optional<task::Goal> goal(int body) const { return task().goal(at_hand().state, body); }
  /// How many goals are behind it.
  int goals_behind() const { return at_hand().state.goal; }
  /// Every goal of a task that has some.
  bool done() const { return task().done(at_hand().state); }
  /// The goals that are due are, for now.
  bool reached() const { return !std::isnan(at_hand().state.reached_since); }
  Eigen::Vector2d target(const scene::Scene& scene, int body, double now, double ahead) const {
    return task().target(scene, body, elapsed(now), ahead, at_hand().state);
  }
  Eigen::Vector2d velocity(double now, double ahead) const {
    return task().velocity(elapsed(now), ahead);
  }

 private:
  struct Followed {
    task::Task task;
    double since = -1.0;  // negative: not begun [s]
    task::State state = {};
  };
  Followed& at_hand() { return clients_ ? *clients_ : own_; }
  const Followed& at_hand() const { return clients_ ? *clients_ : own_; }

  Followed own_;
  std::optional<Followed> clients_;
};

}  // namespace c3rt::planner
