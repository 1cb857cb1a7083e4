#include "idl/client/mover.hpp"

#include <stdexcept>

#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/client/part.hpp"
#include "idl/client/settings.hpp"
#include "idl/validate.hpp"

namespace c3rt::client {
namespace {

constexpr double kRate = 1000.0;  // of the robot's states [Hz]

void set(const JointPositions& command, wire::RobotMotion& sample) {
  sample.kind = c3rt_v2_MOTION_JOINT_POSITION;
  fill(sample.q_rad, command.q);
}
void set(const JointVelocities& command, wire::RobotMotion& sample) {
  sample.kind = c3rt_v2_MOTION_JOINT_VELOCITY;
  fill(sample.dq_rad_per_s, command.dq);
}
void set(const std::optional<Elbow>& elbow, wire::RobotMotion& sample) {
  if (!elbow) return;
  sample.has_elbow = true;
  sample.elbow_q3_rad = elbow->q3;
  sample.elbow_sign = elbow->sign;
}
void set(const CartesianPose& command, wire::RobotMotion& sample) {
  sample.kind = c3rt_v2_MOTION_CARTESIAN_POSE;
  fill(sample.p_WE_m, command.p);
  fill_unit(sample.q_WE, command.q);
  set(command.elbow, sample);
}
void set(const CartesianVelocities& command, wire::RobotMotion& sample) {
  sample.kind = c3rt_v2_MOTION_CARTESIAN_VELOCITY;
  fill(sample.v_WE_m_per_s, command.v);
  fill(sample.omega_WE_rad_per_s, command.omega);
  set(command.elbow, sample);
}

}  // namespace

wire::RobotMotion motion_sample(const Command& command, std::int64_t state_ns) {
  wire::RobotMotion sample{};
  std::visit(
      [&sample](const auto& chosen) {
        set(chosen, sample);
        sample.finished = chosen.finished;
      },
      command);
  sample.origin.state_ns = state_ns;
  sample.header.time_ns = state_ns;
  // the readers would refuse it
  if (const wire::Refusal refused = wire::validate(sample))
    throw std::invalid_argument(to_text(refused));
  return sample;
}

/// One run().
class Mover::Moving final : public Process::Part {
 public:
  Moving(Mover& mover, const Place& place)
      : Part(c3rt_v2_PROCESS_IMPEDANCE, place, {kRate, true}), mover_(mover) {}

 private:
  void step(std::int64_t now_ns) override;
  wire::Answer obey(c3rt_v2_RequestVerb verb) override {
    stopped_ = verb == c3rt_v2_REQUEST_STOP;  // or it is to recover
    return {true, stopped_ ? "moves nothing until recover" : "goes on"};
  }

  Mover& mover_;
  wire::Reader<wire::RobotState> states_{bus(), kQueue};
  wire::Writer<wire::RobotMotion> motions_{bus()};
  std::atomic<std::uint64_t>& sent_ = endpoint().status().counter("motions");
  Observations observed_;
  bool stopped_ = false;
};

void Mover::Moving::step(std::int64_t now_ns) {
  serve(now_ns);
  // of several that came at once the newest is answered
  std::optional<wire::RobotState> newest;
  wire::RobotState state{};
  while (states_.take_next_effective(now_ns, state)) {
    observed_.add(state);
    newest = state;
  }
  if (!newest || stopped_) return;
  if (!began()) say(c3rt_v2_SERVICE_RUNNING, "moves the arm");
  begin();
  const std::int64_t state_ns = newest->header.time_ns, begin_ns = rt::now_ns();
  const std::optional<Command> command =
      mover_.move(base::seconds(state_ns), observed_.situation(now_ns).effector);
  endpoint().status().compute().add(base::seconds(rt::now_ns() - begin_ns));
  if (!command) return;
  wire::RobotMotion sample = motion_sample(*command, state_ns);
  if (motions_.write(sample, lockstep() ? now_ns : rt::now_ns())) ++sent_;
}

Mover::Mover() : Process(c3rt_v2_PROCESS_IMPEDANCE) {}

// not inline: the vtable is the package's
Mover::~Mover() = default;

std::unique_ptr<Process::Part> Mover::take_part(const Place& place) {
  return std::make_unique<Moving>(*this, place);
}

}  // namespace c3rt::client
