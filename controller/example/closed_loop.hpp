#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "controller/example/controller.hpp"
#include "controller/example/experiment.hpp"
#include "controller/lcs/lemke.hpp"

namespace c3rt::example {

/// What is controlled.
class Plant {
 public:
  virtual ~Plant() = default;
  virtual void reset(const Eigen::VectorXd& x) = 0;
  /// One simulation step.
  /// @return false where the plant has no next state: its LCP has no solution
  virtual bool step(const Eigen::VectorXd& u, Eigen::VectorXd& x, Eigen::VectorXd& lambda) = 0;
};

/// The experiment's own LCS, taken anew about every state, each LCP solved by Lemke's method.
class LcsPlant final : public Plant {
 public:
  explicit LcsPlant(const Experiment& experiment);
  void reset(const Eigen::VectorXd& x) override;
  bool step(const Eigen::VectorXd& u, Eigen::VectorXd& x, Eigen::VectorXd& lambda) override;

 private:
  const Experiment& experiment_;
  Eigen::VectorXd x_;
  lcs::Lemke lemke_;
};

/// A run from its start to its end, or to where something failed.
struct Trajectory {
  Eigen::MatrixXd x;            // (n_x × steps+1)
  Eigen::MatrixXd u;            // (n_u × steps) as applied, without the disturbance
  Eigen::MatrixXd lambda;       // (n_lambda × steps) of the plant
  Eigen::VectorXd cost;         // (steps+1) accumulated before each step
  Eigen::VectorXd cost_to_go;   // of each control step's plan, rolled out through the planning LCS;
                                // NaN where that has no solution
  int controller_failures = 0;  // control steps without an answer: the last input is held
  bool plant_failed = false;
  bool stopped = false;  // by the observer
  bool succeeded = false;

  Eigen::Index steps() const { return u.cols(); }
};

/// Told of progress; answers whether to go on.
class Observer {
 public:
  virtual ~Observer() = default;
  virtual bool go_on(double t) = 0;
};

/// One trial in closed loop. Deterministic in experiment, seed and trial.
Trajectory run(const Experiment& experiment, std::uint64_t seed, int trial, Controller& controller,
               Plant& plant, Observer* observer = nullptr);

/// Cost (14) of applying `u` (n_u × N) to the system from x, x's own term included; NaN where an
/// LCP on the way has no solution.
double cost_to_go(const Experiment& experiment, const lcs::Lcs& lcs, const Eigen::VectorXd& x,
                  const Eigen::MatrixXd& u);

}  // namespace c3rt::example
