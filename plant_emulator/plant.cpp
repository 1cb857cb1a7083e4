#include "plant_emulator/plant.hpp"

#include <cmath>
#include <stdexcept>

namespace c3rt::plant {
namespace {

// The brake: the joints' own damping while it is engaged, and a spring once they rest. Ours: about
// critical for the arm's inertia at its home pose.
const Vector7d kBrakeDamping =
    (Vector7d() << 50, 50, 50, 50, 30, 25, 15).finished();  // [N m s/rad]
const Vector7d kHoldStiffness =
    (Vector7d() << 600, 600, 600, 600, 250, 150, 50).finished();  // [N m/rad]
constexpr double kRestVelocity = 0.02;                            // [rad/s]

// A hand that holds an object: on a table that is tilted by 1 degree a sphere creeps 0.02 mm/s. It
// lets go when the end effector is this close to touching.
constexpr double kHandDamping = 1000.0;  // of all six degrees of freedom [N s/m, N m s/rad]
constexpr double kTouch = 5e-4;          // [m]

}  // namespace

bool divides_cycle(double step) noexcept {
  const double steps = kCycle / step;
  return steps > 0.5 && std::abs(steps - std::round(steps)) < 1e-9;
}

Plant::Plant(const Parameters& parameters)
    : parameters_(parameters),
      model_(build_model({parameters.world, {}, 1, 1, 0, ""})),
      data_(mj_makeData(model_.get())),
      substeps_(static_cast<int>(std::lround(kCycle / parameters.world.step))),
      site_(mj_name2id(model_.get(), mjOBJ_SITE, "end_effector")),
      jacobian_(3, model_->nv),
      hold_q_(parameters.initial_q) {
  if (!divides_cycle(parameters.world.step))
    throw std::invalid_argument("plant: step must divide 0.001 s");
  if ((parameters.initial_q.array() < parameters.limits.q_min.array()).any() ||
      (parameters.initial_q.array() > parameters.limits.q_max.array()).any())
    throw std::invalid_argument("plant: initial_q must lie within the joints' limits");
  for (int i = 0; i < kJoints; ++i)
    arm_bodies_[static_cast<std::size_t>(i)] =
        mj_name2id(model_.get(), mjOBJ_BODY, ("link" + std::to_string(i + 1)).c_str());
  arm_bodies_.back() = mj_name2id(model_.get(), mjOBJ_BODY, "end_effector");
  Eigen::Map<Vector7d>(data_->qpos) = parameters.initial_q;
  Eigen::Map<Vector7d>(model_->dof_damping) += kBrakeDamping;
  state_.object_count = static_cast<int>(parameters.world.objects.size());
  for (std::size_t i = 0; i < parameters.world.objects.size(); ++i) {
    const ObjectParameters& object = parameters_.world.objects[i];
    state_.objects[i].shape = object.object.shape();
    state_.objects[i].name = object.object.name.c_str();
    if (!object.held) continue;
    held_.push_back(static_cast<int>(i));
    hand_damping(static_cast<int>(i)).array() += kHandDamping;
  }
  mj_step1(model_.get(),
           data_.get());  // kept between cycles: everything that depends on position and velocity
  read();
}

void Plant::set_command(const Vector7d& tau, std::uint64_t seq, std::int64_t state_ns) noexcept {
  if (state_.time < drop_until_ || seq == newest_seq_) return;
  newest_seq_ = seq;
  if (!tau.allFinite()) {
    events_.errors |= bit(Error::kCommandNotFinite);
    return;
  }
  command_ = tau;
  newest_state_ns_ = state_ns;
  events_.command = true;
}

void Plant::push(int index, const Eigen::Vector3d& impulse) noexcept {
  if (index < 0 || index >= state_.object_count || !impulse.allFinite()) return;
  const int dof = kJoints + 6 * index;
  Eigen::Map<Eigen::Vector3d>(data_->qfrc_applied + dof) = impulse / kCycle;
  push_pending_ = true;
}

Eigen::Map<Eigen::Matrix<double, 6, 1>> Plant::hand_damping(int object) noexcept {
  return Eigen::Map<Eigen::Matrix<double, 6, 1>>(model_->dof_damping + kJoints + 6 * object);
}

void Plant::let_go() noexcept {
  scene::Effector effector;
  effector.p_WE = state_.p_WE;
  effector.radius = parameters_.world.end_effector.sphere_radius;
  for (std::size_t i = 0; i < held_.size();) {
    const scene::Body& object = state_.objects[static_cast<std::size_t>(held_[i])];
    if (scene::gap(effector, object).distance > kTouch) {
      ++i;
      continue;
    }
    hand_damping(held_[i]).array() -= kHandDamping;
    held_[i] = held_.back();
    held_.pop_back();
  }
}

Errors Plant::limits_violated() const noexcept {
  Errors errors = 0;
  const JointLimits& limits = parameters_.limits;
  if ((state_.q.array() < limits.q_min.array()).any() ||
      (state_.q.array() > limits.q_max.array()).any())
    errors |= bit(Error::kJointPositionLimitsViolation);
  if ((state_.dq.array().abs() > limits.dq_max.array()).any())
    errors |= bit(Error::kJointVelocityViolation);
  return errors;
}

void Plant::count_command(bool received) noexcept {
  received_[static_cast<std::size_t>(window_at_)] = received;
  window_at_ = (window_at_ + 1) % kSuccessWindow;
  if (window_ < kSuccessWindow) ++window_;
  lost_in_a_row_ = received ? 0 : lost_in_a_row_ + 1;
  if (!received) ++state_.lost_commands;
}

bool Plant::commands_are_back() noexcept {
  if (!waits_for_commands()) back_ = missing_ = 0;
  if (events_.command) {
    ++back_;
  } else if (back_ > 0 && ++missing_ >= kLostCommandsMax + back_ / 2) {
    back_ = missing_ = 0;
  }
  return waits_for_commands() && back_ >= kCommandsToRecover;
}

void Plant::enter(ModeState next_mode) noexcept {
  const bool was_braked = mode_.mode != Mode::kMove;
  const bool braked = next_mode.mode != Mode::kMove;
  if (was_braked && !braked) {
    Eigen::Map<Vector7d>(model_->dof_damping) -= kBrakeDamping;
    received_.reset();
    window_ = window_at_ = lost_in_a_row_ = 0;
  } else if (!was_braked && braked) {
    Eigen::Map<Vector7d>(model_->dof_damping) += kBrakeDamping;
    holding_ = false;
  }
  mode_ = next_mode;
}

void Plant::step_1ms() noexcept {
  const bool moving = mode_.mode == Mode::kMove;
  if (moving) {
    events_.errors |= limits_violated();
    if (!events_.command && lost_in_a_row_ + 1 >= kLostCommandsMax)
      events_.errors |= bit(Error::kCommunicationConstraintsViolation);
  }
  events_.recover = commands_are_back() || events_.recover;
  const bool command = events_.command;
  enter(next(mode_, events_));
  events_ = {};

  Vector7d tau;
  if (mode_.mode == Mode::kMove) {
    count_command(command);
    if (command) {
      state_.command_seq = newest_seq_;
      state_.command_state_ns = newest_state_ns_;
    }
    tau = command_torque();
  } else {
    window_ = 0;
    received_.reset();
    tau = brake_torque();
  }
  for (int i = 0; i < substeps_; ++i) substep(tau);
  // the damper's share is part of what the arm felt
  if (mode_.mode != Mode::kMove) tau -= kBrakeDamping.cwiseProduct(state_.dq);
  state_.tau = tau;
  if (push_pending_) {
    Eigen::Map<Eigen::VectorXd>(data_->qfrc_applied + kJoints, model_->nv - kJoints).setZero();
    push_pending_ = false;
  }
  ++cycles_;
  read();
  let_go();
}

Vector7d Plant::command_torque() noexcept {
  const Vector7d step = Vector7d::Constant(parameters_.limits.tau_rate_max * kCycle);
  Vector7d tau = command_.cwiseMin(state_.tau + step)
                     .cwiseMax(state_.tau - step)
                     .cwiseMin(parameters_.limits.tau_max)
                     .cwiseMax(-parameters_.limits.tau_max);
  if (tau != command_) ++state_.saturated_cycles;
  return tau;
}

Vector7d Plant::brake_torque() noexcept {
  if (!holding_ && state_.dq.cwiseAbs().maxCoeff() < kRestVelocity) {
    holding_ = true;
    hold_q_ = state_.q;
  }
  if (!holding_) return Vector7d::Zero();
  const Vector7d tau = kHoldStiffness.cwiseProduct(hold_q_ - state_.q);
  return tau.cwiseMin(parameters_.limits.tau_max).cwiseMax(-parameters_.limits.tau_max);
}

Vector7d Plant::gravity_torque() noexcept {
  const Eigen::Map<const Eigen::Vector3d> gravity(model_->opt.gravity);
  Vector7d tau = Vector7d::Zero();
  for (const int body : arm_bodies_) {
    mj_jacBodyCom(model_.get(), data_.get(), jacobian_.data(), nullptr, body);
    tau.noalias() -=
        jacobian_.leftCols<kJoints>().transpose() * (model_->body_mass[body] * gravity);
  }
  return tau;
}

void Plant::substep(const Vector7d& tau) noexcept {
  Eigen::Map<Vector7d>(data_->qfrc_applied) = tau + gravity_torque();
  mj_step2(model_.get(), data_.get());
  mj_step1(model_.get(), data_.get());
}

void Plant::read() noexcept {
  State& s = state_;
  s.time = static_cast<double>(cycles_) * kCycle;
  s.q = Eigen::Map<const Vector7d>(data_->qpos);
  s.dq = Eigen::Map<const Vector7d>(data_->qvel);
  s.p_WE = Eigen::Map<const Eigen::Vector3d>(data_->site_xpos + 3 * site_);
  using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  s.q_WE =
      Eigen::Quaterniond(Eigen::Matrix3d(Eigen::Map<const Rotation>(data_->site_xmat + 9 * site_)));
  s.mode = mode_.mode;
  s.errors = mode_.errors;
  s.command_success_rate =
      window_ > 0 ? static_cast<double>(received_.count()) / static_cast<double>(window_) : 0.0;
  for (int i = 0; i < s.object_count; ++i) {
    scene::Body& object = s.objects[static_cast<std::size_t>(i)];
    const double* q = data_->qpos + kJoints + 7 * i;
    const double* v = data_->qvel + kJoints + 6 * i;
    object.p_WB = Eigen::Vector3d(q[0], q[1], q[2]);
    object.q_WB = Eigen::Quaterniond(q[3], q[4], q[5], q[6]);
    object.v_WB = Eigen::Vector3d(v[0], v[1], v[2]);
    object.omega_WB =
        object.q_WB * Eigen::Vector3d(v[3], v[4], v[5]);  // MuJoCo stores it in the object's axes
  }
  // MuJoCo answers numbers that are not finite by resetting the world; the next cycle makes that an
  // error
  for (const int warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
    if (data_->warning[warning].number > 0) {
      data_->warning[warning].number = 0;
      events_.errors |= bit(Error::kInstabilityDetected);
    }
  }
}

}  // namespace c3rt::plant
