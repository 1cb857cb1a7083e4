#include "plant_emulator/plant.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace c3rt::plant {
namespace {

// The brake: the joints' own damping while it is engaged, and a spring once they rest. Ours: about
// critical for the arm's inertia at its home pose.
const Vector7d kBrakeDamping =
    (Vector7d() << 50, 50, 50, 50, 30, 25, 15).finished();  // [N m s/rad]
const Vector7d kHoldStiffness =
    (Vector7d() << 600, 600, 600, 600, 250, 150, 50).finished();  // [N m/rad]
constexpr double kRestVelocity = 0.02;                            // [rad/s]
constexpr double kGuideDamping = 0.2;  // of the brake's, while a person leads the arm
// what keeps a hand from leading it along or about an axis that is not free; the joints' damping is
// the damper of the turns; ours
constexpr double kFenceStiffness = 3000.0;     // [N/m]
constexpr double kFenceDamping = 100.0;        // [N s/m]
constexpr double kFenceTurnStiffness = 200.0;  // [N m/rad]
constexpr int kElbow = 2;                      // joint 3

// How fast the robot's own controller makes good what a motion is ahead of the arm; ours, for
// joints 1 to 4 about as stiff as libfranka's joint impedance of 3000 N m/rad.
constexpr double kFollow = 60.0;  // [rad/s]

constexpr double kLedOutwards = 0.05;  // a joint that shakes in a hand is not led [rad/s]

/// How much of the brake is engaged.
double brake_share(Mode mode) noexcept {
  return mode == Mode::kMove ? 0.0 : mode == Mode::kGuiding ? kGuideDamping : 1.0;
}

// links whose capsules may not come near each other; those between are their neighbours
constexpr int kShoulder = 2, kForearm = 5;

// A hand that holds an object: on a table that is tilted by 1 degree a sphere creeps 0.02 mm/s. It
// lets go when the end effector is this close to touching.
constexpr double kHandDamping = 1000.0;  // of all six degrees of freedom [N s/m, N m s/rad]
constexpr double kTouch = 5e-4;          // [m]

/// Of the arm in a world of its own: nothing of the simulation is touched.
class ArmKinematics final : public Kinematics {
 public:
  ArmKinematics(const mjModel& model, int site)
      : model_(model),
        data_(mj_makeData(&model)),
        site_(site),
        linear_(3, model.nv),
        angular_(3, model.nv) {}
  Reach at(const Vector7d& q) noexcept override {
    Eigen::Map<Vector7d>(data_->qpos) = q;
    mj_kinematics(&model_, data_.get());
    mj_comPos(&model_, data_.get());
    mj_jacSite(&model_, data_.get(), linear_.data(), angular_.data(), site_);
    using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    Reach reach;
    reach.p_WE = Eigen::Map<const Eigen::Vector3d>(data_->site_xpos + 3 * site_);
    reach.q_WE = Eigen::Quaterniond(
        Eigen::Matrix3d(Eigen::Map<const Rotation>(data_->site_xmat + 9 * site_)));
    reach.J_WE << linear_.leftCols<kJoints>(), angular_.leftCols<kJoints>();
    return reach;
  }

 private:
  const mjModel& model_;
  Data data_;
  int site_;
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> linear_, angular_;
};

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
      turning_jacobian_(3, model_->nv),
      velocity_change_(Eigen::VectorXd::Zero(model_->nv)),
      inertia_torque_(Eigen::VectorXd::Zero(model_->nv)),
      kinematics_(std::make_unique<ArmKinematics>(*model_, site_)),
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
  find_arm_capsules();
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
  gravity_ = gravity_torque();
  read();
}

void Plant::set_command(const Vector7d& tau, std::uint64_t seq, std::int64_t state_ns) noexcept {
  if (by_motion_ || state_.time < drop_until_ || seq == newest_seq_) return;
  newest_seq_ = seq;
  for (int i = 0; i < kJoints; ++i) {
    if (!std::isfinite(tau[i]))
      find({Error::kCommandNotFinite, i + 1, tau[i], parameters_.limits.tau_max[i], "N m"});
  }
  if (!tau.allFinite()) return;
  command_ = tau;
  newest_state_ns_ = state_ns;
  events_.command = true;
}

bool Plant::set_motion(const MotionCommand& motion, std::uint64_t seq,
                       std::int64_t state_ns) noexcept {
  const bool begins = !by_motion_ && mode_.mode == Mode::kIdle && !events_.command;
  const bool goes_on = by_motion_ && motion.kind == generator_.kind();
  if (!begins && !goes_on) return false;
  if (state_.time < drop_until_ || seq == newest_motion_seq_) return true;
  newest_motion_seq_ = seq;
  if (!is_finite(motion)) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    find({Error::kCommandNotFinite, 0, kNan, 0.0, "of a motion"});
    return true;
  }
  if (begins) generator_.begin(motion.kind, state_.q, *kinematics_);
  by_motion_ = true;
  motion_ = motion;
  newest_motion_state_ns_ = state_ns;
  events_.command = true;
  return true;
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

bool Plant::set_collision_behavior(const CollisionBehavior& behavior) noexcept {
  if (mode_.mode == Mode::kMove) return false;
  parameters_.safety.collision = behavior;
  return true;
}

bool Plant::request_guiding(const GuidingAxes& axes) noexcept {
  if (mode_.mode == Mode::kMove || stop_pressed_) return false;
  guiding_ = axes;
  guided_p_WE_ = state_.p_WE;
  guided_q_WE_ = state_.q_WE;
  guided_q3_ = state_.q[kElbow];
  events_.guide = true;
  return true;
}

void Plant::pull(const Eigen::Vector3d& force, double duration) noexcept {
  if (!force.allFinite()) return;
  pull_ = force;
  pull_until_ = state_.time + duration;
}

void Plant::find_arm_capsules() {
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    const int body = model_->geom_bodyid[geom];
    const bool capsule = model_->geom_type[geom] == mjGEOM_CAPSULE;
    const bool of_arm = capsule && model_->geom_group[geom] == kGroupArmPrimitives;
    for (int link = 0; link <= kJoints; ++link) {
      const int link_body = link == 0 ? model_->body_parentid[arm_bodies_[0]]
                                      : arm_bodies_[static_cast<std::size_t>(link) - 1];
      if (!of_arm || body != link_body) continue;
      if (link <= kShoulder) near_.push_back(geom);
      if (link >= kForearm) far_.push_back(geom);
    }
  }
}

double Plant::clearance() const noexcept {
  const auto end = [this](int geom, double side) -> Eigen::Vector3d {
    using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    return Eigen::Map<const Eigen::Vector3d>(data_->geom_xpos + 3 * geom) +
           side * model_->geom_size[3 * geom + 1] *
               Eigen::Map<const Rotation>(data_->geom_xmat + 9 * geom).col(2);
  };
  double least = kNoLimit;
  for (const int a : near_) {
    for (const int b : far_) {
      const double distance =
          segment_distance(end(a, -1.0), end(a, 1.0), end(b, -1.0), end(b, 1.0));
      least = std::min(least, distance - model_->geom_size[3 * a] - model_->geom_size[3 * b]);
    }
  }
  return least;
}

void Plant::find(const Cause& cause) noexcept {
  if (events_.errors == 0) found_ = cause;
  events_.errors |= bit(cause.error);
}

Measured Plant::measured() const noexcept {
  Measured measured;
  measured.q = state_.q;
  measured.dq = state_.dq;
  measured.tau = state_.tau;
  measured.tau_sensor = state_.tau + gravity_;
  measured.p_WE = state_.p_WE;
  measured.V_WE = J_WE_ * state_.dq;
  measured.clearance = clearance();
  return measured;
}

void Plant::note(const Findings& findings) noexcept {
  if (findings.errors == 0) return;
  if (events_.errors == 0) found_ = findings.first;
  events_.errors |= findings.errors;
}

void Plant::follow_motion() noexcept {
  Findings findings;
  generator_.step(events_.command ? &motion_ : nullptr, parameters_, *kinematics_, findings);
  events_.finished = events_.command && motion_.last;
  note(findings);
}

void Plant::judge() noexcept {
  Findings findings;
  judge_limits(measured(), parameters_, findings);
  judge_contacts(state_.external, parameters_.safety.collision, state_.contacts, findings);
  if (parameters_.torque_jump_stops && events_.command && !by_motion_)
    judge_torque_step(state_.tau, command_, parameters_.limits.tau_rate_max, kCycle, findings);
  watch_.judge(events_.command, findings);
  note(findings);
}

void Plant::judge_guiding() noexcept {
  const JointLimits& limits = parameters_.limits;
  for (int i = 0; i < kJoints; ++i) {
    const double q = state_.q[i], dq = state_.dq[i];
    if ((q > limits.q_max[i] && dq > kLedOutwards) || (q < limits.q_min[i] && dq < -kLedOutwards))
      find({Error::kJointMoveInWrongDirection, i + 1, q,
            q > limits.q_max[i] ? limits.q_max[i] : limits.q_min[i], "rad"});
  }
}

void Plant::enter(ModeState next_mode) noexcept {
  const double change = brake_share(next_mode.mode) - brake_share(mode_.mode);
  if (change != 0.0) Eigen::Map<Vector7d>(model_->dof_damping) += change * kBrakeDamping;
  if (change > 0.0) holding_ = false;
  if (mode_.mode != Mode::kMove && next_mode.mode == Mode::kMove) watch_.begin();
  if (next_mode.mode != Mode::kMove) by_motion_ = false;
  const bool stopped_now = mode_.errors == 0 || mode_.mode == Mode::kGuiding;
  if (stopped_now && next_mode.mode == Mode::kReflex && events_.errors != 0) state_.cause = found_;
  if (next_mode.errors == 0) {
    state_.cause = {};
    if (mode_.errors != 0) state_.contacts = {};
  }
  mode_ = next_mode;
}

void Plant::step_1ms() noexcept {
  if (stop_pressed_) events_.stop = true;
  if (by_motion_) follow_motion();
  if (mode_.mode == Mode::kMove) judge();
  if (mode_.mode == Mode::kGuiding) judge_guiding();
  events_.recover = watch_.back(events_.command, waits_for_commands()) || events_.recover;
  const bool command = events_.command;
  enter(next(mode_, events_));
  events_ = {};
  found_ = {};

  Vector7d tau;
  if (mode_.mode == Mode::kMove) {
    watch_.count(command);
    state_.lost_commands = watch_.lost();
    if (command) {
      state_.command_seq = by_motion_ ? newest_motion_seq_ : newest_seq_;
      state_.command_state_ns = by_motion_ ? newest_motion_state_ns_ : newest_state_ns_;
    }
    tau = by_motion_ ? motion_torque() : command_torque();
  } else {
    watch_.rest();
    tau = brake_torque();
  }
  apply_pull();
  const Vector7d dq_before = state_.dq, motors = tau;
  for (int i = 0; i < substeps_; ++i) substep(tau);
  // the damper's share is part of what the arm felt
  const double brake = brake_share(mode_.mode);
  if (brake > 0.0) tau -= brake * kBrakeDamping.cwiseProduct(state_.dq);
  state_.tau = tau;
  if (push_pending_) {
    Eigen::Map<Eigen::VectorXd>(data_->qfrc_applied + kJoints, model_->nv - kJoints).setZero();
    push_pending_ = false;
  }
  ++cycles_;
  read();
  estimate_external(dq_before, motors);
  let_go();
}

void Plant::apply_pull() noexcept {
  if (pull_.isZero(0.0)) return;
  if (state_.time >= pull_until_) pull_.setZero();
  const int body = arm_bodies_.back();
  // MuJoCo takes forces at the centre of mass
  const Eigen::Map<const Eigen::Vector3d> center(data_->xipos + 3 * body);
  Eigen::Map<Eigen::Vector3d>(data_->xfrc_applied + 6 * body) = pull_;
  Eigen::Map<Eigen::Vector3d>(data_->xfrc_applied + 6 * body + 3) =
      (state_.p_WE - center).cross(pull_);
}

void Plant::estimate_external(const Vector7d& dq_before, const Vector7d& tau) noexcept {
  mj_jacSite(model_.get(), data_.get(), jacobian_.data(), turning_jacobian_.data(), site_);
  J_WE_ << jacobian_.leftCols<kJoints>(), turning_jacobian_.leftCols<kJoints>();
  const Vector7d acceleration = (state_.dq - dq_before) / kCycle;
  const Vector7d residual = torque_of(acceleration) - tau;
  state_.external = estimator_.step(residual, acceleration, J_WE_, state_.q_WE, kCycle);
}

Vector7d Plant::torque_of(const Vector7d& acceleration) noexcept {
  velocity_change_.head<kJoints>() = acceleration;
  mj_mulM(model_.get(), data_.get(), inertia_torque_.data(), velocity_change_.data());
  const Eigen::Map<const Vector7d> bias(data_->qfrc_bias), passive(data_->qfrc_passive);
  return inertia_torque_.head<kJoints>() + bias - gravity_ - passive;
}

Vector7d Plant::motion_torque() noexcept {
  // the arm is where the command before this one led: this one is of the cycle's end
  const Vector7d& ddq = generator_.ddq();
  const Vector7d dq = generator_.dq() - kCycle * ddq, q = generator_.q() - kCycle * generator_.dq();
  const Vector7d off = q - state_.q, slow = dq - state_.dq;
  command_ = torque_of(ddq + kFollow * kFollow * off + 2.0 * kFollow * slow);
  return command_torque();
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
  if (mode_.mode == Mode::kGuiding) return guiding_torque();
  if (!holding_ && state_.dq.cwiseAbs().maxCoeff() < kRestVelocity) {
    holding_ = true;
    hold_q_ = state_.q;
  }
  if (!holding_) return Vector7d::Zero();
  const Vector7d tau = kHoldStiffness.cwiseProduct(hold_q_ - state_.q);
  return tau.cwiseMin(parameters_.limits.tau_max).cwiseMax(-parameters_.limits.tau_max);
}

Vector7d Plant::guiding_torque() const noexcept {
  const Eigen::AngleAxisd back(guided_q_WE_ * state_.q_WE.conjugate());
  Vector6d wrench;
  wrench << kFenceStiffness * (guided_p_WE_ - state_.p_WE) -
                kFenceDamping * J_WE_.topRows<3>() * state_.dq,
      kFenceTurnStiffness * back.angle() * back.axis();
  for (int i = 0; i < 6; ++i) {
    if ((guiding_.free >> i & 1U) != 0) wrench[i] = 0.0;
  }
  Vector7d tau = J_WE_.transpose() * wrench;
  if (!guiding_.elbow) tau[kElbow] += kHoldStiffness[kElbow] * (guided_q3_ - state_.q[kElbow]);
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
  Eigen::Map<Vector7d>(data_->qfrc_applied) = tau + gravity_;
  mj_step2(model_.get(), data_.get());
  mj_step1(model_.get(), data_.get());
  gravity_ = gravity_torque();
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
  s.command_success_rate = watch_.success_rate();
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
      find({Error::kInstabilityDetected});
    }
  }
}

}  // namespace c3rt::plant
