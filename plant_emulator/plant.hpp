#pragma once
// The robot's 1 kHz interface, of torques or of motions, on the simulated scene. No network, no
// clock, no files.
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/scene/scene.hpp"
#include "plant_emulator/command_watch.hpp"
#include "plant_emulator/guard.hpp"
#include "plant_emulator/mode.hpp"
#include "plant_emulator/motion.hpp"
#include "plant_emulator/parameters.hpp"

namespace c3rt::plant {

/// Whether whole steps of the integration fill a cycle.
bool divides_cycle(double step) noexcept;

struct State {
  double time;                     // simulated [s]
  Vector7d q = Vector7d::Zero();   // [rad]
  Vector7d dq = Vector7d::Zero();  // [rad/s]
  // applied in the last cycle, after saturation, without gravity [N m]
  Vector7d tau = Vector7d::Zero();
  // of the centre of the end effector's sphere [m]
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WE = Eigen::Quaterniond::Identity();
  Mode mode;
  Errors errors;
  Cause cause;        // of the reflex: what was found first
  External external;  // what acts on the arm, as the robot estimates it
  Contacts contacts;
  double
      command_success_rate;   // of the last kSuccessWindow cycles in Mode::kMove; 0 in other modes
  std::uint64_t command_seq;  // of the newest command applied, 0 for none
  std::int64_t command_state_ns;   // the state stamp that it answered
  std::uint64_t saturated_cycles;  // cycles in which torque or torque rate was cut
  std::uint64_t lost_commands;     // cycles in Mode::kMove without a new command
  int object_count;
  std::array<scene::Body, scene::kMaxBodies> objects;
};

class Plant {
 public:
  /// @throws what build_model throws; std::invalid_argument if the step does not divide a cycle
  explicit Plant(const Parameters& parameters);

  /// Torque for the next cycle and, until it is replaced, those after it. The sequence number of
  /// the last one is no new command. Anything not finite is refused and stops the robot. RT: no
  /// heap, no throw.
  /// @param tau without gravity: the robot adds the torque that carries its own weight [N m]
  /// @param state_ns stamp of the state that the command answers
  void set_command(const Vector7d& tau, std::uint64_t seq, std::int64_t state_ns) noexcept;
  /// What a motion generator wants of the next cycle, which the robot's own controller follows. The
  /// first that comes while the robot is idle takes it; then torques do not move it until the last
  /// one has come. One that is lost is extrapolated with constant acceleration. RT: no heap, no
  /// throw.
  /// @param state_ns stamp of the state that the motion answers
  /// @return false, and nothing is changed: something else moves the robot, or it has to be
  /// recovered
  [[nodiscard]] bool set_motion(const MotionCommand& motion, std::uint64_t seq,
                                std::int64_t state_ns = 0) noexcept;
  void request_stop() noexcept { events_.stop = true; }
  /// Until it is released the stop button keeps the robot stopped, and nothing recovers it; then it
  /// is stopped as by request_stop().
  void press_stop(bool pressed) noexcept { stop_pressed_ = pressed; }
  bool stop_pressed() const noexcept { return stop_pressed_; }
  void request_recovery() noexcept { events_.recover = true; }
  /// A person takes the arm by the hand, or another way, which it obeys unless it moves or its stop
  /// button is pressed. RT: no heap, no throw.
  /// @return whether it will
  bool request_guiding(const GuidingAxes& axes = {}) noexcept;
  /// And lets go of it.
  void release() noexcept { events_.release = true; }

  /// @return false, and nothing is changed, while the arm moves. RT: no heap, no throw.
  [[nodiscard]] bool set_collision_behavior(const CollisionBehavior& behavior) noexcept;

  /// One cycle of the robot: judges command and limits, then moves the world by kCycle. RT: no
  /// heap, no throw.
  void step_1ms() noexcept;

  /// At the end of the last cycle.
  const State& state() const noexcept { return state_; }
  /// It stopped because commands were missing, and moves by itself once they come again.
  bool waits_for_commands() const noexcept {
    return parameters_.recovers_alone && mode_.mode == Mode::kReflex &&
           mode_.errors == bit(Error::kCommunicationConstraintsViolation);
  }

  /// What moves the robot is a motion generator, not torques.
  bool moved_by_motion() const noexcept { return by_motion_; }
  /// What that one has led to so far.
  const MotionGenerator& motion() const noexcept { return generator_; }

  /// Pushes an object at its centre of mass during the next cycle. RT: no heap, no throw.
  void push(int index, const Eigen::Vector3d& impulse) noexcept;  // [N s], in W
  /// A hand, or whatever is in the way, acts on the end effector's centre for a while. RT: no heap,
  /// no throw.
  void pull(const Eigen::Vector3d& force, double duration) noexcept;  // [N] in W, [s]
  /// Ignores commands for a while. RT: no heap, no throw.
  void drop_commands(double duration) noexcept { drop_until_ = state_.time + duration; }  // [s]

  const mjModel& model() const noexcept { return *model_; }
  const mjData& data() const noexcept { return *data_; }

 private:
  Measured measured() const noexcept;
  void judge() noexcept;
  void follow_motion() noexcept;
  void note(const Findings& findings) noexcept;
  void judge_guiding() noexcept;
  void find(const Cause& cause) noexcept;
  double clearance() const noexcept;
  void find_arm_capsules();
  Vector7d guiding_torque() const noexcept;
  void apply_pull() noexcept;
  void estimate_external(const Vector7d& dq_before, const Vector7d& tau) noexcept;
  Vector7d command_torque() noexcept;
  Vector7d motion_torque() noexcept;
  Vector7d torque_of(const Vector7d& acceleration) noexcept;  // without gravity [N m]
  Vector7d brake_torque() noexcept;
  Vector7d gravity_torque() noexcept;
  void enter(ModeState next_mode) noexcept;
  void substep(const Vector7d& tau) noexcept;
  void read() noexcept;
  /// Damping of an object's six degrees of freedom, in the model.
  Eigen::Map<Eigen::Matrix<double, 6, 1>> hand_damping(int object) noexcept;
  void let_go() noexcept;  // of the objects that the end effector touches

  Parameters parameters_;
  Model model_;
  Data data_;
  int substeps_;
  int site_;
  std::array<int, kJoints + 1> arm_bodies_{};
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> jacobian_, turning_jacobian_;
  Eigen::Matrix<double, 6, kJoints> J_WE_ = Eigen::Matrix<double, 6, kJoints>::Zero();
  Eigen::VectorXd velocity_change_, inertia_torque_;  // of every degree of freedom
  Vector7d gravity_;                                  // that carries the arm where it is [N m]
  ExternalEstimator estimator_;
  std::unique_ptr<Kinematics> kinematics_;
  std::vector<int> near_, far_;  // geoms of base and shoulder; of forearm, wrist and end effector

  ModeState mode_{Mode::kIdle, 0};
  Events events_{};
  Cause found_;                          // in this cycle, first
  Vector7d command_ = Vector7d::Zero();  // newest accepted
  std::uint64_t newest_seq_ = 0;
  std::int64_t newest_state_ns_ = 0;
  bool by_motion_ = false;
  MotionCommand motion_;  // newest accepted
  std::uint64_t newest_motion_seq_ = 0;
  std::int64_t newest_motion_state_ns_ = 0;
  MotionGenerator generator_;
  CommandWatch watch_;
  bool stop_pressed_ = false;
  GuidingAxes guiding_;
  // where the hand took the arm
  Eigen::Vector3d guided_p_WE_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond guided_q_WE_ = Eigen::Quaterniond::Identity();
  double guided_q3_ = 0.0;  // [rad]
  Vector7d hold_q_;
  bool holding_ = true;  // at rest; false while the brake still stops the arm
  double drop_until_ = 0.0;
  double pull_until_ = 0.0;
  Eigen::Vector3d pull_ = Eigen::Vector3d::Zero();  // [N]
  bool push_pending_ = false;
  std::vector<int> held_;  // objects that a hand holds
  std::int64_t cycles_ = 0;
  State state_{};
};

}  // namespace c3rt::plant
