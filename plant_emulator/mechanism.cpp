#include "plant_emulator/mechanism.hpp"

#include <stdexcept>

#include "controller/mjcf/coordinates.hpp"
#include "controller/mjcf/loaded.hpp"
#include "controller/mjcf/mechanism.hpp"

namespace c3rt::plant {

struct Mechanism::Simulation {
  explicit Simulation(const std::string& file) : loaded(file) {
    loaded.go_home();
    coordinates = mjcf::Coordinates(loaded);
  }

  mjcf::Loaded loaded;
  mjcf::Coordinates coordinates;
};

Mechanism::Mechanism(const std::string& mjcf, double step) {
  (void)mjcf::read_mechanism(mjcf);  // what it refuses
  simulation_ = std::make_unique<Simulation>(mjcf);
  simulation_->loaded.model()->opt.timestep = step;
}
Mechanism::~Mechanism() = default;
Mechanism::Mechanism(Mechanism&&) noexcept = default;
Mechanism& Mechanism::operator=(Mechanism&&) noexcept = default;

void Mechanism::reset(const Eigen::VectorXd& x) {
  const Eigen::Index n_v = simulation_->loaded.model()->nv;
  if (x.size() != 2 * n_v || !x.allFinite()) {
    throw std::invalid_argument("mechanism: expected a state of " + std::to_string(2 * n_v) +
                                " finite numbers, got another one");
  }
  simulation_->coordinates.to_mujoco(x.head(n_v), x.tail(n_v), simulation_->loaded.data());
}

void Mechanism::step(const Eigen::Ref<const Eigen::VectorXd>& u) noexcept {
  mjData* data = simulation_->loaded.data();
  for (Eigen::Index i = 0; i < u.size(); ++i) data->ctrl[i] = u[i];
  mj_step(simulation_->loaded.model(), data);
}

void Mechanism::state(Eigen::Ref<Eigen::VectorXd> x) const noexcept {
  const Eigen::Index n_v = simulation_->loaded.model()->nv;
  simulation_->coordinates.from_mujoco(simulation_->loaded.data(), x.head(n_v), x.tail(n_v));
}

}  // namespace c3rt::plant
