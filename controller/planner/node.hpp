#pragma once
// The planner on the types of the wire: newest samples in, one plan out. No bus, no clock, no
// thread: service.hpp has those, a test gives it none.
#include <array>
#include <cstdint>
#include <optional>

#include "controller/model/arm.hpp"
#include "controller/planner/planner.hpp"
#include "idl/topics.hpp"

namespace c3rt::planner {

class Node {
 public:
  struct Input {
    bool has_state = false;                                                      // one has come
    wire::RobotState state{};                                                    // the newest
    wire::RobotCommand command{};                                                // the newest
    std::array<std::optional<wire::ObjectEstimate>, scene::kMaxBodies> objects;  // by index
    Target target = ScenarioTarget{};
    bool stopped = false;  // by a person
    bool spoilt = false;   // a fault: the plan shall not be finite
  };
  struct Output {
    /// false: nothing is sent. What does not know where the arm is asks nothing of it; without
    /// plans the arm is held.
    bool plans = false;
    wire::Plan plan{};
    wire::PlannerDebug debug{};
    std::int64_t effective_ns = 0;  // both take effect then
    double measured = 0.0;          // how long the solve took [s]
  };
  /// How time passes while it plans.
  struct Clock {
    std::int64_t (*now_ns)() noexcept;  // of the machine
    bool realtime = false;              // false: a solve takes solve_time, and there is no deadline
    double solve_time = 0.0;            // [s]
  };

  /// @throws std::invalid_argument as Planner
  Node(const Parameters& parameters, model::Arm arm, const Clock& clock,
       const c3::Parallel& parallel = {});

  /// Valid until the next step. What is sent takes effect at a time that does not depend on how
  /// long the solve took, unless that was too long.
  const Output& step(std::int64_t now_ns, const Input& in);
  const Output& output() const noexcept { return output_; }  // of the last step

  /// As Planner::set_weights.
  void set_weights(const Parameters& parameters) { planner_.set_weights(parameters); }

  const Planner& planner() const noexcept { return planner_; }

 private:
  planner::Input planner_input(std::int64_t now_ns, const Input& in);
  void fill_plan(const Plan& plan, const Input& in) noexcept;

  const Parameters parameters_;
  const Clock clock_;
  Planner planner_;
  model::Arm arm_;
  double solve_time_;  // of the last solve [s]
  Output output_;
};

}  // namespace c3rt::planner
