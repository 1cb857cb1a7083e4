#include "cli/example/plants.hpp"

#include "cli/progress.hpp"
#include "controller/model/cart_pole.hpp"
#include "controller/model/mechanism_model.hpp"
#include "plant_emulator/cart_pole.hpp"
#include "plant_emulator/mechanism.hpp"

namespace c3rt::cli {
namespace {

class NonlinearCartPole final : public example::Plant {
 public:
  NonlinearCartPole(const model::CartPoleParameters& p, double step)
      : cart_pole_({p.cart_mass, p.pole_mass, p.pole_length, p.center_length, 0.0, 0.0,
                    p.wall_stiffness, 0.0, p.wall_distance, p.gravity, step}) {}

  void reset(const Eigen::VectorXd& x) override { cart_pole_.reset(x); }

  bool step(const Eigen::VectorXd& u, Eigen::VectorXd& x, Eigen::VectorXd& lambda) override {
    cart_pole_.reset(x);  // the noise of the loop is added to x
    lambda = cart_pole_.wall_forces();
    cart_pole_.step(u[0]);
    x = cart_pole_.state();
    return true;
  }

 private:
  plant::CartPole cart_pole_;
};

class MujocoMechanism final : public example::Plant {
 public:
  MujocoMechanism(const model::MechanismModel& model, double step)
      : mechanism_(model.mechanism().file(), step) {}

  void reset(const Eigen::VectorXd& x) override { mechanism_.reset(x); }

  bool step(const Eigen::VectorXd& u, Eigen::VectorXd& x, Eigen::VectorXd& lambda) override {
    mechanism_.reset(x);  // the noise of the loop is added to x
    mechanism_.step(u);
    mechanism_.state(x);
    lambda.setZero();  // MuJoCo's contacts are not those of the model
    return true;
  }

 private:
  plant::Mechanism mechanism_;
};

}  // namespace

std::unique_ptr<example::Plant> make_plant(const example::Experiment& experiment) {
  if (!experiment.mujoco_plant) return std::make_unique<example::LcsPlant>(experiment);
  if (const auto* of = dynamic_cast<const model::MechanismModel*>(experiment.plant.get()))
    return std::make_unique<MujocoMechanism>(*of, experiment.simulation_step);
  return std::make_unique<NonlinearCartPole>(
      dynamic_cast<const model::CartPole&>(*experiment.plant).parameters(),
      experiment.simulation_step);
}

const Eigen::MatrixXd* TimedController::decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x,
                                               double t) {
  const double start = seconds_now();
  const Eigen::MatrixXd* inputs = controller_.decide(lcs, x, t);
  seconds_.push_back(seconds_now() - start);
  return inputs;
}

}  // namespace c3rt::cli
