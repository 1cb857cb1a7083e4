#include "plant_emulator/cart_pole.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "plant_emulator/scene.hpp"

namespace c3rt::plant {
namespace {

// MuJoCo refuses a point mass; this is 1e-8 of the pole's inertia about its hinge
constexpr double kSmallestInertia = 1e-9;  // [kg m²]

void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(std::string("cart pole: ") + what);
}

bool positive(double number) { return std::isfinite(number) && number > 0.0; }
bool not_negative(double number) { return std::isfinite(number) && number >= 0.0; }

void check(const CartPoleParameters& p) {
  require(positive(p.cart_mass), "cart_mass must be positive");
  require(positive(p.pole_mass), "pole_mass must be positive");
  require(positive(p.pole_length), "pole_length must be positive");
  require(positive(p.center_length), "center_length must be positive");
  require(not_negative(p.pole_inertia), "pole_inertia must not be negative");
  require(not_negative(p.cart_damping), "cart_damping must not be negative");
  require(not_negative(p.wall_stiffness), "wall_stiffness must not be negative");
  require(not_negative(p.wall_damping), "wall_damping must not be negative");
  require(positive(p.wall_distance), "wall_distance must be positive");
  require(not_negative(p.gravity), "gravity must not be negative");
  require(positive(p.step) && p.step <= 1e-2, "step must be in (0, 0.01] s");
}

std::string xml(const CartPoleParameters& p) {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10);
  const double inertia = std::max(p.pole_inertia, kSmallestInertia);
  text << R"(<mujoco model="cart_pole">
<compiler angle="radian" inertiafromgeom="false"/>
<option timestep=")"
       << p.step << R"(" gravity="0 0 )" << -p.gravity << R"(" integrator="Euler"/>
<worldbody>
<body name="cart">
<joint name="rail" type="slide" axis="1 0 0" damping=")"
       << p.cart_damping << R"("/>
<inertial pos="0 0 0" mass=")"
       << p.cart_mass << R"(" diaginertia="0.01 0.01 0.01"/>
<body name="pole">
<joint name="hinge" type="hinge" axis="0 -1 0"/>
<inertial pos="0 0 )"
       << p.center_length << R"(" mass=")" << p.pole_mass << R"(" diaginertia=")" << inertia << " "
       << inertia << " " << inertia << R"("/>
</body>
</body>
</worldbody>
</mujoco>
)";
  return text.str();
}

}  // namespace

struct CartPole::Simulation {
  Model model;
  Data data;
};

CartPoleParameters CartPoleParameters::hardware() {
  return {0.978, 0.411, 0.6, 0.4267, 0.0, 0.0, 100.0, 0.0, 0.39, 9.81, 1e-3};
}

CartPole::CartPole(const CartPoleParameters& parameters) : parameters_(parameters) {
  check(parameters);
  Model model = compile_model(xml(parameters));
  Data data(mj_makeData(model.get()));
  simulation_ = std::make_unique<Simulation>(Simulation{std::move(model), std::move(data)});
}

CartPole::~CartPole() = default;
CartPole::CartPole(CartPole&&) noexcept = default;
CartPole& CartPole::operator=(CartPole&&) noexcept = default;

void CartPole::reset(const Eigen::Vector4d& x) {
  require(x.allFinite(), "the state must be finite");
  mjData& data = *simulation_->data;
  mj_resetData(simulation_->model.get(), &data);
  Eigen::Map<Eigen::Vector2d>(data.qpos) = x.head<2>();
  Eigen::Map<Eigen::Vector2d>(data.qvel) = x.tail<2>();
}

void CartPole::step(double force) noexcept {
  mjData& data = *simulation_->data;
  const Eigen::Vector2d walls = wall_forces();
  const double on_tip = walls[1] - walls[0];
  // the tip's Jacobian is [1, −l_p cos θ]
  data.qfrc_applied[0] = force + on_tip;
  data.qfrc_applied[1] = -parameters_.pole_length * std::cos(data.qpos[1]) * on_tip;
  mj_step(simulation_->model.get(), &data);
}

Eigen::Vector4d CartPole::state() const noexcept {
  const mjData& data = *simulation_->data;
  return {data.qpos[0], data.qpos[1], data.qvel[0], data.qvel[1]};
}

Eigen::Vector2d CartPole::wall_forces() const noexcept {
  const Eigen::Vector4d x = state();
  const double tip = x[0] - parameters_.pole_length * std::sin(x[1]);
  const double tip_rate = x[2] - parameters_.pole_length * std::cos(x[1]) * x[3];
  const auto push = [this](double depth, double rate) {
    if (depth <= 0.0) return 0.0;
    return std::max(0.0, parameters_.wall_stiffness * depth + parameters_.wall_damping * rate);
  };
  return {push(tip - parameters_.wall_distance, tip_rate),
          push(-tip - parameters_.wall_distance, -tip_rate)};
}

}  // namespace c3rt::plant
