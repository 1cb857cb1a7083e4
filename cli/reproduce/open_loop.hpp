#pragma once
// One planning problem, answered by C3 and by the monolithic problem (15).
#include <string>
#include <vector>

#include "cli/reproduce/context.hpp"
#include "config/scenario.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::cli::reproduce {

/// What the planner was asked at one instant of a run: x̂ and what was wanted, from ground truth.
struct Question {
  double time;  // since C3 took over [s]
  scene::Scene scene;
  bool rolling;                       // Phase I of the heuristic
  std::vector<scene::Scene> desired;  // of the stages 0 … N
};

/// Instants of a run, as many as wanted and evenly spread over it.
std::vector<Question> questions(const Run& run, const config::Scenario& scenario, int count);

/// How good the inputs are that an algorithm gives: the cost of (15) when the planning LCS is
/// simulated with them.
struct Answers {
  std::vector<double> costs;  // one for each question; not finite where there is no answer
  std::vector<double> times;  // of the solves [s]
};

/// @param scenario whose planner answers
/// @param judge whose weights and LCS (Stewart and Trinkle's) the cost is made of
Answers answer_with_c3(const std::vector<Question>& questions, const config::Scenario& scenario,
                       const config::Scenario& judge);

struct MonolithicAnswers : Answers {
  int proven = 0;  // to a gap of 1e-4
};

/// (15) itself, by the exact search, started from C3's answer.
/// @param limit of each [s]
MonolithicAnswers answer_monolithic(const std::vector<Question>& questions,
                                    const config::Scenario& judge, double limit,
                                    const Context& context);

}  // namespace c3rt::cli::reproduce
