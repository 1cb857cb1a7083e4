#include "controller/impedance/load_parameters.hpp"

#include <cmath>

#include "config/service.hpp"
#include "controller/model/load_parameters.hpp"

namespace c3rt::impedance {

namespace {

constexpr config::Range kAngle{-2 * M_PI, 2 * M_PI};

Gains load_gains(config::Section section) {
  Gains gains;
  gains.inertia = section.choice<Inertia>("inertia", {{"full", Inertia::kFull},
                                                      {"diagonal", Inertia::kDiagonal},
                                                      {"uncoupled", Inertia::kUncoupled}});
  gains.stiffness.head<3>().setConstant(section.number("stiffness_translation_per_s2", {0, 5000}));
  gains.stiffness.tail<3>().setConstant(section.number("stiffness_rotation_per_s2", {0, 5000}));
  gains.damping.head<3>().setConstant(section.number("damping_translation_per_s", {0, 500}));
  gains.damping.tail<3>().setConstant(section.number("damping_rotation_per_s", {0, 500}));
  gains.null_space_stiffness = section.number("stiffness_null_space_nm_per_rad", {0, 100});
  gains.null_space_damping = section.number("damping_null_space_nm_s_per_rad", {0, 100});
  gains.null_space_q = section.numbers("q_null_space_rad", 7, kAngle);
  section.finish();
  return gains;
}

void require_ordered(const config::Section& section, const char* min_key, const char* max_key,
                     const Eigen::VectorXd& min, const Eigen::VectorXd& max) {
  if ((min.array() >= max.array()).any()) {
    section.fail(max_key, std::string("every entry above that of ") + min_key, "one that is not");
  }
}

Limits load_limits(config::Section section) {
  Limits limits;
  limits.reference_speed = section.number("reference_speed_m_per_s", {0.01, 2});
  limits.reference_angular_speed = section.number("reference_angular_speed_rad_per_s", {0.01, 5});
  limits.plan_speed = section.number("plan_speed_m_per_s", {0.01, 2}, 0.25);
  limits.plan_acceleration = section.number("plan_acceleration_m_per_s2", {0.1, 200}, 25.0);
  limits.lead_acceleration = section.number("lead_acceleration_m_per_s2", {0.1, 200}, 6.25);
  limits.lead_angular_acceleration =
      section.number("lead_angular_acceleration_rad_per_s2", {0.1, 500}, 15.0);
  limits.plan_force = section.number("plan_force_n", {0, 100}, 30.0);
  limits.workspace_min = section.numbers("workspace_min_m", 3, {-1.2, 1.2});
  limits.workspace_max = section.numbers("workspace_max_m", 3, {-1.2, 1.2});
  require_ordered(section, "workspace_min_m", "workspace_max_m", limits.workspace_min,
                  limits.workspace_max);
  limits.tau_max = section.numbers("tau_max_nm", 7, {0.1, 87});
  limits.tau_rate_max = section.number("tau_rate_max_nm_per_s", {1, 1000});
  limits.q_min = section.numbers("q_min_rad", 7, kAngle);
  limits.q_max = section.numbers("q_max_rad", 7, kAngle);
  require_ordered(section, "q_min_rad", "q_max_rad", limits.q_min, limits.q_max);
  limits.dq_max = section.numbers("dq_max_rad_per_s", 7, {0.01, 10});
  limits.state_timeout = section.number("state_timeout_s", {0.002, 1});
  limits.plan_timeout = section.number("plan_timeout_s", {0.005, 5});
  limits.stop_damping = section.number("stop_damping_per_s", {0, 100});
  section.finish();
  return limits;
}

Thread load_thread(config::Section section) {
  Thread thread{};
  thread.fifo_priority = section.integer("fifo_priority", {0, 99});
  thread.cpu = section.integer("cpu", {-1, 1023});
  section.finish();
  return thread;
}

}  // namespace

Parameters load_parameters(config::Section section, const config::Robot& robot) {
  Parameters parameters;
  parameters.period = 1.0 / section.number("rate_hz", {100, 2000});
  parameters.reference = section.choice<Reference>(
      "reference", {{"hold", Reference::kHold}, {"interpolate", Reference::kInterpolate}});
  parameters.feed_forward = section.boolean("feed_forward");
  parameters.feed_forward_threshold = section.number("feed_forward_threshold_n", {0, 100});
  parameters.gains = load_gains(section.section("gains"));
  parameters.limits = load_limits(section.section("limits"));
  parameters.thread = load_thread(section.section("thread"));
  parameters.arm = model::load_arm(robot);
  if (section.has("urdf")) parameters.arm.urdf_path = section.text("urdf");
  section.finish();
  return parameters;
}

Parameters load_from_scenario(config::Section& root) {
  const config::Service service = config::load_service(root);
  Parameters parameters = load_parameters(root.section("impedance"), config::load_robot(root));
  parameters.recovers_alone = service.recovery == config::Recovery::kAutomatic;
  return parameters;
}

}  // namespace c3rt::impedance
