#pragma once
// What the bodies are to do, whatever kind of task it is.
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "controller/scene/scene.hpp"

namespace c3rt::task {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// How far a run has come with its task.
class Progress {
 public:
  virtual ~Progress() = default;
  /// @param elapsed since the task began [s]
  /// @param bodies  where they are, in W [m]; at least one
  virtual void add(double elapsed, const std::vector<Eigen::Vector2d>& bodies) = 0;
  virtual double amount() const = 0;              // of Task::unit(), with fractions
  virtual int completed() const = 0;              // whole ones; 1 of a task that is done once
  virtual std::vector<double> times() const = 0;  // of each that is completed [s]
  /// From when on the error is judged, since the task began; kNone before that is known [s].
  virtual double judged_from() const = 0;
};

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
  Eigen::Vector2d target(const scene::Scene& scene, int body, double elapsed,
                         double ahead) const noexcept {
    return held_->target(scene, body, elapsed, ahead);
  }
  /// And with which velocity, in W [m/s].
  Eigen::Vector2d velocity(double elapsed, double ahead) const noexcept {
    return held_->velocity(elapsed, ahead);
  }
  /// How far a body is from where it should be [m]: of a task in time from the point of that time,
  /// of another one from its line.
  double error(double elapsed, const Eigen::Vector2d& body) const noexcept {
    return held_->error(elapsed, body);
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

 private:
  struct Concept {
    virtual ~Concept() = default;
    virtual const char* kind() const noexcept = 0;
    virtual const char* unit() const noexcept = 0;
    virtual Eigen::Vector2d target(const scene::Scene&, int, double, double) const noexcept = 0;
    virtual Eigen::Vector2d velocity(double, double) const noexcept = 0;
    virtual double error(double, const Eigen::Vector2d&) const noexcept = 0;
    virtual Eigen::Vector2d middle() const = 0;
    virtual std::vector<Eigen::Vector2d> outline(const Eigen::AlignedBox2d&) const = 0;
    virtual std::unique_ptr<Progress> progress() const = 0;
    virtual bool repeats() const noexcept = 0;
    virtual std::optional<Along> along(const scene::Scene&, int) const noexcept = 0;
    virtual std::optional<bool> arrived(const Eigen::Vector2d&) const noexcept = 0;
    virtual std::vector<std::pair<std::string, Task>> readings() const = 0;
  };
  template <typename Kind>
  struct Held final : Concept {
    explicit Held(Kind given) : task(std::move(given)) {}
    const char* kind() const noexcept override { return Kind::kKind; }
    const char* unit() const noexcept override { return Kind::kUnit; }
    Eigen::Vector2d target(const scene::Scene& scene, int body, double elapsed,
                           double ahead) const noexcept override {
      return task.target(scene, body, elapsed, ahead);
    }
    Eigen::Vector2d velocity(double elapsed, double ahead) const noexcept override {
      return task.velocity(elapsed, ahead);
    }
    double error(double elapsed, const Eigen::Vector2d& body) const noexcept override {
      return task.error(elapsed, body);
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
    Kind task;
  };

  std::shared_ptr<const Concept> held_;
};

}  // namespace c3rt::task
