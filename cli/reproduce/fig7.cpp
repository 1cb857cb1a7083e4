// Figure 7: what the iterations of Algorithm 1 do to a contact force that is about to begin.
#include <array>

#include <fmt/format.h>

#include "cli/reproduce/loop.hpp"
#include "controller/model/cart_pole.hpp"

namespace c3rt::cli::reproduce {
namespace {

using Eigen::VectorXd;

// the paper does not say which: the cart moves to the right, the tip 1 cm from the right wall
const Eigen::Vector4d kState(0.44, 0.1, 0.6, -0.2);
constexpr std::array<int, 3> kIterations{1, 3, 10};
constexpr std::array<const char*, 3> kCurveColors{"#b0b0b0", "#d04020", "#1f5fd0"};

/// max |min(λ, E x + F λ + H u + c)| of each stage
VectorXd violations(const lcs::Lcs& lcs, const c3::Sizes& s, const Eigen::MatrixXd& z) {
  VectorXd result(s.N);
  for (int k = 0; k < s.N; ++k) {
    const VectorXd stage = z.col(k);
    const VectorXd y = lcs.E * s.x(stage) + lcs.F * s.lambda(stage) + lcs.H * s.u(stage) + lcs.c;
    result[k] = s.lambda(stage).cwiseMin(y).cwiseAbs().maxCoeff();
  }
  return result;
}

}  // namespace

void fig7(const Context& context) {
  example::Experiment experiment = context.scenario("cart_pole_hardware", {}).experiment;
  experiment.c3.trace = true;
  const c3::Sizes s = example::sizes(experiment);
  const lcs::Lcs lcs = example::planning_system(experiment, kState);
  example::C3Controller controller(experiment);
  if (controller.decide(lcs, kState, 0.0) == nullptr)
    throw std::runtime_error("fig7: C3 has no answer");
  const c3::Solution& solution = controller.solution();

  const VectorXd times = VectorXd::LinSpaced(s.N, 0.0, (s.N - 1) * experiment.planning_step);
  Panel force{"", "", "force of the right wall λ₁ [N]", {}};
  Panel violation{"", "time ahead [s]", "violation max |min(λ, y)|", {}};
  ordered_json results{{"what", "fig7"}, {"state", numbers(kState)}, {"time_s", numbers(times)}};
  std::vector<std::vector<std::string>> rows{
      {"ADMM iteration", "largest λ₁ [N]", "largest violation", "mean violation"}};
  for (std::size_t i = 0; i < kIterations.size(); ++i) {
    const c3::Iterate& iterate = solution.trace.at(static_cast<std::size_t>(kIterations[i] - 1));
    const std::string name = fmt::format("iteration {}", kIterations[i]);
    const VectorXd lambda = iterate.z.row(s.n_x + model::CartPoleLayout::right_wall);
    const VectorXd violated = violations(lcs, s, iterate.z);
    force.curves.push_back({name, kCurveColors[i], times, lambda, false, true});
    violation.curves.push_back({name, kCurveColors[i], times, violated, false, true});
    rows.push_back({std::to_string(kIterations[i]), shown(lambda.maxCoeff()),
                    shown(violated.maxCoeff()), shown(violated.mean())});
    results["iterations"][std::to_string(kIterations[i])] = {{"lambda_1_n", numbers(lambda)},
                                                             {"violation", numbers(violated)}};
  }
  fmt::print("Figure 7: cart-pole at [{:g} m, {:g} rad, {:g} m/s, {:g} rad/s], walls at {:g} m\n\n",
             kState[0], kState[1], kState[2], kState[3],
             dynamic_cast<const model::CartPole&>(*experiment.model).parameters().wall_distance);
  print_table(rows);
  context.finish(results, "Figure 7: the iterations near a contact", {force, violation});
}

}  // namespace c3rt::cli::reproduce
