#pragma once

#include <Eigen/Core>

#include "controller/c3/known_plan.hpp"
#include "controller/example/experiment.hpp"

namespace c3rt::example {

/// Chooses inputs from a state: C3, the monolithic MIQP, or whatever else is to be compared.
class Controller {
 public:
  virtual ~Controller() = default;

  /// Forgets earlier control steps.
  virtual void reset() = 0;

  /// @param lcs the planning system about x
  /// @param t   time since the start of the run [s]
  /// @return the planned inputs (n_u × N), the first one to be applied; null where there is none
  virtual const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x,
                                        double t) = 0;
};

/// C3 with the experiment's settings, costs and start policy.
class C3Controller final : public Controller {
 public:
  /// @throws std::invalid_argument as c3::Solver
  explicit C3Controller(const Experiment& experiment);

  void reset() override;
  const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x, double t) override;

  /// Of the last decision.
  const c3::Solution& solution() const { return *solution_; }

 private:
  StartPolicy policy_;
  double reset_period_;
  c3::Sizes sizes_;
  double rho_;
  c3::Solver solver_;
  Eigen::MatrixXd x_desired_, u_;
  c3::KnownPlan known_;
  c3::Start start_;
  long period_ = 0;
  bool has_start_ = false;
  const c3::Solution* solution_ = nullptr;
};

}  // namespace c3rt::example
