#pragma once
// What the bodies are to do, whatever kind of task it is.
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "controller/base/words.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::task {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Where a body lies on the table and how it is turned, in W.
struct Placement {
  Placement(double x, double y) : at(x, y) {}
  template <typename Derived>
  Placement(const Eigen::MatrixBase<Derived>& p_WB) : at(p_WB) {}  // NOLINT: upright
  template <typename Derived, int options>
  Placement(const Eigen::MatrixBase<Derived>& p_WB, const Eigen::Quaternion<double, options>& q_WB)
      : at(p_WB), q(q_WB) {}

  Eigen::Vector2d at;  // [m]
  Eigen::Quaternion<double, Eigen::DontAlign> q = Eigen::Quaterniond::Identity();
};

/// How far a run has come with its task.
class Progress {
 public:
  virtual ~Progress() = default;
  /// @param elapsed since the task began [s]
  /// @param bodies  at least one
  virtual void add(double elapsed, const std::vector<Placement>& bodies) = 0;
  virtual double amount() const = 0;              // of Task::unit(), with fractions
  virtual int completed() const = 0;              // whole ones; 1 of a task that is done once
  virtual std::vector<double> times() const = 0;  // of each that is completed [s]
  /// From when on the error is judged, since the task began; kNone before that is known [s].
  virtual double judged_from() const = 0;
  /// The task's own figures by the names of Task::criteria(); what the run does not give is left
  /// out.
  virtual std::vector<std::pair<std::string, double>> results() const { return {}; }
};

/// An axis of a body and where it is to point; how the body is turned about it does not matter.
struct AxisGoal {
  Eigen::Vector3d of_body;  // in the body's frame, of length 1
  Eigen::Vector3d to;       // in W, of length 1
};

/// Where a body is to come to rest.
struct Goal {
  Eigen::Vector2d at;                           // in W [m]
  std::optional<double> yaw;                    // about z; none: however it is turned [rad]
  double position_tolerance;                    // [m]
  double angle_tolerance;                       // [rad]
  std::optional<AxisGoal> axis = std::nullopt;  // in the place of a yaw

  /// The turn about z that brings a body's orientation nearest to the goal's; 0 where none does
  /// anything [rad].
  double turn_about_z(const scene::Body& body) const noexcept;
};

/// What a task of several goals remembers. Whoever follows a task keeps it beside it; State{} is
/// its beginning.
struct State {
  int goal = 0;                  // the first that is not done yet
  double reached_since = kNone;  // it has been reached; kNone: it is not [s]
  double since = kNone;          // its time runs; kNone: the task has not begun [s]
  int missed = 0;                // of those before it: not reached in their time
};

/// What a client's task has to keep.
struct Limits {
  int bodies;                     // of the scene
  Eigen::AlignedBox2d reach;      // of every place that a body is to come to, in W [m]
  bool goals_of_several = false;  // goals can be worked at where there are several bodies
  bool holds(const Eigen::Vector2d& at) const;
  /// "x in [0.37, 0.73] and y in [-0.28, 0.28] m", `inside` the border by so much.
  std::string words(double inside = 0.0) const;
};
using base::words;

/// Where a body is on the way of a task that orders the bodies.
struct Along {
  double way;     // that it has to go along it, negative past its place [m]
  double beside;  // distance from it [m]
  double place;   // along it; more is farther ahead [m]
};

/// A kind of task, by value: made from any struct that has the members below (circle.hpp is one).
class Task {
 public:
  template <typename Kind, typename = std::enable_if_t<!std::is_same_v<std::decay_t<Kind>, Task>>>
  Task(Kind kind)
      : held_(std::make_shared<const Held<Kind>>(std::move(kind))) {}  // NOLINT: by value

  /// "circle": as the registry has it.
  const char* kind() const noexcept { return held_->kind(); }
  /// The task as a struct of its kind; nullptr if it is of another one.
  template <typename Kind>
  const Kind* as() const noexcept {
    const auto* held = dynamic_cast<const Held<Kind>*>(held_.get());
    return held == nullptr ? nullptr : &held->task;
  }

  /// What its progress counts: "circles".
  const char* unit() const noexcept { return held_->unit(); }
  /// Where a body should be at a stage of the horizon, in W [m].
  /// @param elapsed since the task began [s]  @param ahead of the stage [s]
  /// @param state of a task with goals
  Eigen::Vector2d target(const scene::Scene& scene, int body, double elapsed, double ahead,
                         const State& state = {}) const noexcept {
    return held_->target(scene, body, elapsed, ahead, state);
  }
  /// Where a body is to come to rest next, or for good; none of a task that goes on and on, or
  /// that leaves the body alone.
  std::optional<Goal> goal(const State& state, int body) const noexcept {
    return held_->goal(state, body);
  }
  /// How many bodies there have to be.
  int bodies() const noexcept { return held_->bodies(); }
  /// Whether all goals are done; never of a task without any.
  bool done(const State& state) const noexcept { return held_->done(state); }
  /// Keeps the state true. @param elapsed since the task began [s]
  void advance(double elapsed, const scene::Scene& scene, State& state) const noexcept {
    held_->advance(elapsed, scene, state);
  }
  /// And with which velocity, in W [m/s].
  Eigen::Vector2d velocity(double elapsed, double ahead) const noexcept {
    return held_->velocity(elapsed, ahead);
  }
  /// How far a body is from where it should be [m]: of a task in time from the point of that time,
  /// of another one from its line.
  double error(double elapsed, const Eigen::Vector2d& at, int body = 0) const noexcept {
    return held_->error(elapsed, at, body);
  }
  /// A point about which the task takes place, in W [m].
  Eigen::Vector2d middle() const { return held_->middle(); }
  /// The desired path as a line to draw. @param tracks that the bodies have left, in W [m]
  std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d& tracks) const {
    return held_->outline(tracks);
  }
  std::unique_ptr<Progress> progress() const { return held_->progress(); }
  /// Whether it is done over and over, as often as the scenario says.
  bool repeats() const noexcept { return held_->repeats(); }
  /// Where a body is on the task's way; none where bodies have no order.
  std::optional<Along> along(const scene::Scene& scene, int body) const noexcept {
    return held_->along(scene, body);
  }
  /// Whether a body has arrived for good; none where there is no such place.
  std::optional<bool> arrived(const Eigen::Vector2d& body) const noexcept {
    return held_->arrived(body);
  }
  /// Other ways to read the same task, by which its error is reported as well.
  std::vector<std::pair<std::string, Task>> readings() const { return held_->readings(); }
  /// Figures of a run with this task by which a scenario may judge it, beside those of any task.
  std::vector<std::string> criteria() const { return held_->criteria(); }
  /// Of a client's task: what was expected and what came; empty where it can be done.
  std::string refusal(const Limits& limits) const { return held_->refusal(limits); }
  /// "circle about (0.55, 0) m, radius 0.1 m, lead 20 deg"
  std::string describe() const { return held_->describe(); }
  /// The same for a run: what is drawn follows its seed. A task that draws nothing is itself.
  Task seeded(std::uint64_t seed) const {
    Task task = *this;
    if (std::shared_ptr<const Concept> drawn = held_->seeded(seed)) task.held_ = std::move(drawn);
    return task;
  }
  /// Whether both are copies of one: a task that was given again is another.
  bool is(const Task& other) const noexcept { return held_ == other.held_; }

 private:
  struct Concept {
    virtual ~Concept() = default;
    virtual const char* kind() const noexcept = 0;
    virtual const char* unit() const noexcept = 0;
    virtual Eigen::Vector2d target(const scene::Scene&, int, double, double,
                                   const State&) const noexcept = 0;
    virtual std::optional<Goal> goal(const State&, int) const noexcept = 0;
    virtual int bodies() const noexcept = 0;
    virtual bool done(const State&) const noexcept = 0;
    virtual void advance(double, const scene::Scene&, State&) const noexcept = 0;
    virtual Eigen::Vector2d velocity(double, double) const noexcept = 0;
    virtual double error(double, const Eigen::Vector2d&, int) const noexcept = 0;
    virtual Eigen::Vector2d middle() const = 0;
    virtual std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d&) const = 0;
    virtual std::unique_ptr<Progress> progress() const = 0;
    virtual bool repeats() const noexcept = 0;
    virtual std::optional<Along> along(const scene::Scene&, int) const noexcept = 0;
    virtual std::optional<bool> arrived(const Eigen::Vector2d&) const noexcept = 0;
    virtual std::vector<std::pair<std::string, Task>> readings() const = 0;
    virtual std::vector<std::string> criteria() const = 0;
    virtual std::string refusal(const Limits&) const = 0;
    virtual std::string describe() const = 0;
    virtual std::shared_ptr<const Concept> seeded(std::uint64_t) const = 0;
  };
  // a kind that draws nothing has no word about a seed
  template <typename Kind, typename = void>
  struct Draws : std::false_type {};
  template <typename Kind>
  struct Draws<Kind, std::void_t<decltype(&Kind::seeded)>> : std::true_type {};
  // a kind without goals has no state and no word about them
  template <typename Kind, typename = void>
  struct HasGoals : std::false_type {};
  template <typename Kind>
  struct HasGoals<Kind, std::void_t<decltype(&Kind::goal)>> : std::true_type {};
  template <typename Kind>
  struct Held final : Concept {
    explicit Held(Kind given) : task(std::move(given)) {}
    const char* kind() const noexcept override { return Kind::kKind; }
    const char* unit() const noexcept override { return Kind::kUnit; }
    Eigen::Vector2d target(const scene::Scene& scene, int body, double elapsed, double ahead,
                           [[maybe_unused]] const State& state) const noexcept override {
      if constexpr (HasGoals<Kind>::value) {
        return task.target(scene, body, state);
      } else {
        return task.target(scene, body, elapsed, ahead);
      }
    }
    std::optional<Goal> goal([[maybe_unused]] const State& state,
                             [[maybe_unused]] int body) const noexcept override {
      if constexpr (HasGoals<Kind>::value) return task.goal(state, body);
      return std::nullopt;
    }
    int bodies() const noexcept override {
      if constexpr (HasGoals<Kind>::value) return task.bodies();
      return 1;
    }
    bool done([[maybe_unused]] const State& state) const noexcept override {
      if constexpr (HasGoals<Kind>::value) return task.done(state);
      return false;
    }
    void advance([[maybe_unused]] double elapsed, [[maybe_unused]] const scene::Scene& scene,
                 [[maybe_unused]] State& state) const noexcept override {
      if constexpr (HasGoals<Kind>::value) task.advance(elapsed, scene, state);
    }
    Eigen::Vector2d velocity(double elapsed, double ahead) const noexcept override {
      return task.velocity(elapsed, ahead);
    }
    double error(double elapsed, const Eigen::Vector2d& at,
                 [[maybe_unused]] int body) const noexcept override {
      if constexpr (HasGoals<Kind>::value) {
        return task.error(elapsed, at, body);
      } else {
        return task.error(elapsed, at);
      }
    }
    Eigen::Vector2d middle() const override { return task.middle(); }
    std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d& tracks) const override {
      return task.outline(tracks);
    }
    std::unique_ptr<Progress> progress() const override { return task.progress(); }
    bool repeats() const noexcept override { return Kind::kRepeats; }
    std::optional<Along> along(const scene::Scene& scene, int body) const noexcept override {
      return task.along(scene, body);
    }
    std::optional<bool> arrived(const Eigen::Vector2d& body) const noexcept override {
      return task.arrived(body);
    }
    std::vector<std::pair<std::string, Task>> readings() const override { return task.readings(); }
    std::vector<std::string> criteria() const override { return Kind::criteria(); }
    std::string refusal(const Limits& limits) const override { return task.refusal(limits); }
    std::string describe() const override { return task.describe(); }
    std::shared_ptr<const Concept> seeded([[maybe_unused]] std::uint64_t seed) const override {
      if constexpr (Draws<Kind>::value) return std::make_shared<const Held>(task.seeded(seed));
      return nullptr;
    }
    Kind task;
  };

  std::shared_ptr<const Concept> held_;
};

}  // namespace c3rt::task
