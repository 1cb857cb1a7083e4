#pragma once
// What an experiment simulates, and a controller with a stopwatch.
#include <memory>
#include <vector>

#include "controller/example/closed_loop.hpp"

namespace c3rt::cli {

/// The experiment's LCS, or in MuJoCo the nonlinear cart-pole or the mechanism. The experiment
/// outlives it.
std::unique_ptr<example::Plant> make_plant(const example::Experiment& experiment);

/// Times every decision of another controller.
class TimedController final : public example::Controller {
 public:
  explicit TimedController(example::Controller& controller) : controller_(controller) {}
  void reset() override { controller_.reset(); }
  const Eigen::MatrixXd* decide(const lcs::Lcs& lcs, const Eigen::VectorXd& x, double t) override;
  const std::vector<double>& seconds() const { return seconds_; }

 private:
  example::Controller& controller_;
  std::vector<double> seconds_;
};

}  // namespace c3rt::cli
