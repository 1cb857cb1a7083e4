#pragma once
// The C3 problems that the benchmarks solve, each at states that occur in a run.
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/c3/solver.hpp"

namespace bench {

struct State {
  Eigen::VectorXd x0, x_desired;  // (n_x), the same target at every stage
  c3rt::lcs::Lcs lcs;
};

struct Problem {
  std::string name;
  c3rt::c3::Sizes sizes;
  c3rt::c3::Settings settings;
  c3rt::c3::Costs costs;
  c3rt::c3::Constraints constraints;
  std::vector<State> states;

  Eigen::MatrixXd x_desired(const State& state) const {
    return state.x_desired.replicate(1, sizes.N + 1);
  }
};

/// "cart_pole" (Table III), "gaiting" (Table I), "pivoting" (Table II): the published weights and
/// settings, at 16 states of the closed loop; "1_ball" (Stewart–Trinkle, with kConvex Anitescu),
/// "2_balls" (Stewart–Trinkle, 14 states and 18 λ), "3_balls" (Anitescu, 18 and 24): s = 3, N = 5,
/// along a push. Made once, then copied.
/// @throws std::invalid_argument for another name, or where the projection does not suit the model
Problem problem(const std::string& name, c3rt::c3::ProjectionKind projection, int N);

}  // namespace bench
