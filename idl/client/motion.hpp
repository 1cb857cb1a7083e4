#pragma once
// What a planner of one's own plans from and what it gives, and both on the types of the wire.
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "idl/topics.hpp"

namespace c3rt::client {

using Vector = std::array<double, 3>;      // in W
using Quaternion = std::array<double, 4>;  // w x y z

/// The end effector and its arm.
struct Effector {
  Vector p{};                  // p_WE [m]
  Vector v{};                  // of the last states [m/s]
  std::array<double, 7> q{};   // of the joints [rad]
  std::array<double, 7> dq{};  // [rad/s]
  bool moves = false;          // follows commands: not stopped, in no reflex
};

/// The newest estimate of an object.
struct Object {
  std::string name;
  bool valid = false;        // false: lost, the numbers are the last good ones
  Vector p{};                // p_WB of the centre of mass [m]
  Quaternion q{1, 0, 0, 0};  // q_WB
  Vector v{};                // [m/s]
  Vector omega{};            // [rad/s]
  double age = 0.0;          // since the exposure [s]
};

struct Situation {
  double time = 0.0;  // of the session's clock [s]
  Effector effector;
  std::map<int, Object> objects;  // by their index in the scenario
};

/// Where the end effector shall be, `after` seconds from the time when the plan takes effect.
struct Knot {
  Vector p{};                // p_WE [m]
  Vector v{};                // [m/s]
  double after = 0.0;        // [s]
  Quaternion q{0, 1, 0, 0};  // q_WE; as it is here, the tool points down
  Vector force{};            // of the contacts on the end effector [N]
};

struct Motion {
  std::vector<Knot> knots;     // one: a state to follow; several: a motion; none: nothing is sent
  std::string phase = "task";  // "wait", "approach", "rest" and "hold" are the way to the task,
                               // with any other word it has begun
};

/// What has been heard of arm and objects.
class Observations {
 public:
  void add(const wire::RobotState& state);
  void add(const wire::ObjectEstimate& estimate) { estimates_[estimate.object_index] = estimate; }
  bool has_state() const noexcept { return !states_.empty(); }
  Situation situation(std::int64_t now_ns) const;  // of has_state()
  wire::Origin origin() const;                     // of a plan that is made from them

 private:
  std::deque<wire::RobotState> states_;  // the newest last; the first is what v is measured from
  std::map<int, wire::ObjectEstimate> estimates_;
};

/// The motion as a plan that takes effect at that time. Quaternions are scaled to norm 1.
/// @param valid_for after that the arm holds [s]
/// @throws std::invalid_argument naming what cannot be sent: "knots: expected 1 to 16, got 17"
wire::Plan plan_sample(const Motion& motion, std::int64_t effective_ns, double valid_for);

}  // namespace c3rt::client
