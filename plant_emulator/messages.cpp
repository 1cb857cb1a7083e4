#include "plant_emulator/messages.hpp"

namespace c3rt::plant {
namespace {

void copy(const Vector7d& from, double (&to)[kJoints]) noexcept { Eigen::Map<Vector7d>{to} = from; }
void copy(const Eigen::Vector3d& from, double (&to)[3]) noexcept {
  Eigen::Map<Eigen::Vector3d>{to} = from;
}
void copy(const Eigen::Quaterniond& from, double (&to)[4]) noexcept {
  to[0] = from.w();
  to[1] = from.x();
  to[2] = from.y();
  to[3] = from.z();
}

c3rt_v2_RobotMode robot_mode(Mode mode) noexcept {
  switch (mode) {
    case Mode::kIdle:
      return c3rt_v2_ROBOT_IDLE;
    case Mode::kMove:
      return c3rt_v2_ROBOT_MOVE;
    case Mode::kReflex:
      return c3rt_v2_ROBOT_REFLEX;
    case Mode::kUserStopped:
      return c3rt_v2_ROBOT_USER_STOPPED;
  }
  return c3rt_v2_ROBOT_REFLEX;
}

}  // namespace

wire::RobotState robot_state(const State& state) noexcept {
  wire::RobotState sample{};
  copy(state.q, sample.q_rad);
  copy(state.dq, sample.dq_rad_per_s);
  copy(state.tau, sample.tau_nm);
  copy(state.p_WE, sample.p_WE_m);
  copy(state.q_WE, sample.q_WE);
  sample.mode = robot_mode(state.mode);
  sample.errors = state.errors;
  sample.command_success_rate = state.command_success_rate;
  sample.command_seq = state.command_seq;
  sample.command_state_ns = state.command_state_ns;
  return sample;
}

wire::Scene scene(const State& state, bool exposure) noexcept {
  wire::Scene sample{};
  sample.exposure = exposure;
  copy(state.q, sample.q_rad);
  copy(state.p_WE, sample.p_WE_m);
  sample.object_count = state.ball_count;
  for (int i = 0; i < state.ball_count; ++i) {
    const scene::Body& body = state.balls[static_cast<std::size_t>(i)];
    c3rt_v2_SceneObject& object = sample.objects[i];
    copy(body.p_WB, object.p_WB_m);
    copy(body.q_WB, object.q_WB);
    copy(body.v_WB, object.v_WB_m_per_s);
    copy(body.omega_WB, object.omega_rad_per_s);
  }
  return sample;
}

}  // namespace c3rt::plant
