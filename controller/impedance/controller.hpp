#pragma once
// One cycle of the impedance process as a function: newest samples in, torque out. Knows no bus,
// thread or clock.
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/impedance/knots.hpp"
#include "controller/impedance/law.hpp"
#include "controller/impedance/mode.hpp"
#include "controller/impedance/parameters.hpp"
#include "controller/model/arm.hpp"

namespace c3rt::impedance {

enum class PlanStatus {
  kOk,
  kTruncated,  // the planner's deadline struck: less optimal, still a plan
  kFallback,   // the planner's substitute for a failed solve: tracked, its force is not fed forward
  kUnknown,    // no value that we know: not tracked
};

struct Plan {
  std::uint64_t session_id = 0;
  std::int64_t stamp_ns = 0;
  std::int64_t valid_until_ns = 0;
  PlanStatus status = PlanStatus::kUnknown;
  int knot_count = 0;
  Knots knots;  // the first knot_count of them: one is x_d, a state to follow; more are a motion
};

/// The newest samples; a caller that never received one says so. A plan is given from its stamp on,
/// not before.
struct Input {
  std::int64_t now_ns = 0;

  bool has_state = false;
  std::uint64_t session_id = 0;  // of the robot state
  std::int64_t state_stamp_ns = 0;
  std::int64_t answered_ns = 0;  // the state that the robot's newest command answered; 0: none yet
  Vector7d q = Vector7d::Zero();
  Vector7d dq = Vector7d::Zero();
  bool robot_moves = false;  // takes commands: no reflex, not stopped by its user

  bool has_plan = false;
  Plan plan;

  bool stop = false;  // requests of a person, true for one cycle
  bool recover = false;
};

/// Cycles without a new robot state for which the torque stays as it was; the robot itself forgives
/// as many lost commands. After them it fades out and the arm coasts: a law that acts on a state
/// that does not change drives the arm away. For as many in a row the state may be too old before
/// that is a fault: after a pause of the whole machine the first one at hand is old, the next ones
/// are not. Then nothing is sent until states come again, so that the robot stops the arm by
/// itself.
constexpr int kPatience = 20;

/// How old, in cycles and on average over as many as kLoopMemory, the newest command may be that
/// the robot has got: what it answers, and the state that tells of it. A loop with more delay than
/// that feeds the arm's motion instead of damping it. One that is late brakes the arm, by a damping
/// that bears such delays, until it is well again. 19 lost commands alone do not make it late. Of
/// an arm with a joint faster than kSwinging of its limit, which no plan asks for, less is too
/// late: it may swing, and a light wrist then goes from 0.1 of its limit to all of it in 90 ms.
/// States that come one after the other, each older than kPatience, brake it, too: up to
/// `state_timeout` the damping bears them, and an arm that is left to coast goes far in that time.
constexpr double kLateLoop = 3.5, kLoopIsWell = 2.5, kLoopMemory = 100.0;
/// The same of so many of the newest commands that the robot has got, each as late as it came, or
/// as the gap before it was long, and no more than kLongestLag: two commands in a row that are 8
/// cycles old, or two gaps of 7, are known at once, long before the average of all cycles tells; a
/// single gap of any length is forgiven.
constexpr double kFewCommands = 4.0, kLongestLag = 8.0;
constexpr double kLateSwinging = 1.5, kSwinging = 0.35;

/// Good robot states in a row after which a controller that recovers alone goes on.
constexpr int kGoodStates = 200;

/// What is wrong with the robot state; anything but kNone stops the arm (kStale: after kPatience
/// cycles).
enum class StateFault { kNone, kStale, kNotFinite, kJointPosition, kJointVelocity };
StateFault judge_state(const Input& input, const Limits& limits) noexcept;

enum class PlanVerdict { kGood, kNone, kOtherSession, kInvalid, kStale };
PlanVerdict judge_plan(const Input& input, const Limits& limits) noexcept;

enum class StopReason {
  kNone,
  kRequested,
  kStateStale,
  kStateNotFinite,
  kJointPosition,
  kJointVelocity,
  kTorqueNotFinite,
};
/// For a person: "the robot state is stale".
const char* to_text(StopReason reason) noexcept;

/// Since the start, in cycles unless said otherwise.
struct Counters {
  std::uint64_t stale_plan_events = 0;    // times that a tracked plan became too old
  std::uint64_t plans_other_session = 0;  // plans refused: of another session
  std::uint64_t plans_invalid = 0;  // plans refused: not finite, out of all measure, status unknown
  std::uint64_t workspace_clamps = 0;  // the plan was outside the box
  std::uint64_t plan_clamps = 0;       // it asked for more than the arm gives: speed, lead or force
  std::uint64_t torque_clamps = 0;
  std::uint64_t torque_rate_clamps = 0;
  std::uint64_t late_loops = 0;  // times that commands or states came too late to act on
  std::uint64_t stops = 0;       // times that the arm was stopped
};

struct Output {
  Mode mode;
  bool commands;                 // the torque is to be sent; else the robot brakes by itself
  Vector7d tau;                  // without gravity [N m]
  Eigen::Vector3d p_WE_desired;  // what the law tracked [m]
  Eigen::Vector3d v_WE_desired;  // [m/s]
  Eigen::Quaterniond q_WE_desired;
  StopReason stop_reason;
  bool ends_alone;  // the stop, once good states come steadily
  PlanVerdict plan;
  int steady_cycles;  // in a row: the robot moves, and is held or tracks
  Counters counters;
};

/// The impedance controller at a fixed rate.
///
/// The reference begins where the arm is, at rest, whenever the arm was not under our control: at
/// the start, after a stop, while the robot takes no commands, after cycles or states that were
/// missing, and when a plan comes after none. From there it moves towards the plan (or the pose to
/// hold) at most at the limits' speeds, v_d changes at most at their acceleration, and it never
/// leads the arm by more than the limits allow. So whatever a plan asks, the arm is asked for no
/// more than it can give; near the joints' velocity limits for less and less.
///
/// After cycles or states that were missing the arm swings: nothing damped it. It is brought to
/// rest first; a reference that went on at once would feed a swing that the torque, whose rate is
/// limited, follows too late to damp.
///
/// The torque changes at most by tau_rate_max * period per cycle. Where what the plan asks changes
/// faster, and for all of it after a gap or a change of mode, all joints change in proportion: else
/// the joints that need little torque would have theirs before those that need much, which turns
/// the elbow and the wrist.
///
/// A robot of a new session is a new robot: all memory of the old one, a latched stop included, is
/// dropped.
class Controller {
 public:
  Controller(const Parameters& parameters, model::Arm arm);

  /// RT: no heap, no lock, no throw.
  Output step(const Input& input) noexcept;

  /// The arm as of the last step that was not kWait.
  const ArmState& arm() const noexcept { return state_; }

 private:
  void meet_new_robot(std::uint64_t session_id) noexcept;
  void change_mode(const Input& input) noexcept;
  void watch_loop(const Input& input) noexcept;
  /// How late the newest few commands came, the one that is waited for among them. @param age of
  /// the newest one now; all in cycles
  double take_lag(const Input& input, double age) noexcept;
  void rest_here() noexcept;
  bool stop_ends_alone() const noexcept;
  bool recovers(bool asked) noexcept;
  Goal target(const Input& input) noexcept;
  void move_reference(const Input& input) noexcept;
  bool stands(const Input& input) const noexcept;
  Vector7d damping(const Input& input) const noexcept;
  Vector7d law_torque(const Input& input) noexcept;
  Vector7d limited(const Vector7d& wanted) noexcept;

  const Parameters parameters_;
  model::Arm arm_;
  ArmState state_;

  std::uint64_t session_id_ = 0;
  Mode mode_ = Mode::kWait;
  StopReason stop_reason_ = StopReason::kNone;
  StateFault fault_ = StateFault::kNone;
  int stale_cycles_ = 0, good_cycles_ = 0, steady_cycles_ = 0;  // in a row
  std::int64_t previous_now_ns_ = 0;
  bool new_state_ = false;  // of this cycle or the one before
  bool old_state_ = false;  // older than the law may act on
  std::int64_t seen_state_ns_ = 0;
  int same_state_cycles_ = 0;  // in a row
  double loop_age_ = 1.0;      // average [cycles]
  double lag_ = 1.0;           // of the newest commands that the robot has got [cycles]
  std::int64_t answered_ns_ = 0,
               answered_at_ns_ = 0;  // by the newest, and when that was seen first
  bool late_ = false;                // the loop
  bool away_ = false;                // cycles or states were missing: the reference begins anew
  PlanVerdict plan_verdict_ = PlanVerdict::kNone;
  std::int64_t judged_plan_ns_ = 0;  // stamp of the newest plan that was counted
  Eigen::Isometry3d X_WE_hold_ = Eigen::Isometry3d::Identity();
  Goal reference_;
  Vector7d tau_of_goal_ = Vector7d::Zero();
  Vector7d tau_ = Vector7d::Zero();
  bool catches_up_ = false;    // after a gap or a change of mode: the torque is not yet the law's
  bool brakes_ = false;        // after a gap: the arm has not come to rest yet
  int own_torque_cycles_ = 0;  // in a row: the torque was the law's
  Counters counters_;
};

}  // namespace c3rt::impedance
