#pragma once
// Plans for what the planner of a recorded run was asked.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/gap/decisions.hpp"
#include "config/scenario.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::cli::gap {

/// What the planner was asked at one instant of a run: x̂ and what was wanted, from ground truth.
struct Question {
  double time;  // since the task began [s]
  scene::Scene scene;
  bool rolling;                       // Phase I of the heuristic
  std::vector<scene::Scene> desired;  // of the stages 0 … N
};

/// Instants of a run's plans, as many as wanted and evenly spread over it.
/// @param recording of a run of one sphere by the strategy time_heuristic
/// @throws mcap::Error for what is no recording, std::runtime_error if it never began its task
std::vector<Question> questions(const std::filesystem::path& recording,
                                const config::Scenario& scenario, int count);

/// The problem (15) of each question, with the scenario's weights and the LCS of Stewart and
/// Trinkle, and the scenario's own answer to it: a fresh planner, question by question.
/// @throws UsageError for another strategy or several bodies
Decisions of_questions(const std::vector<Question>& questions, const config::Scenario& scenario);

/// What another planner answers.
/// @param scenario of the recording that the questions are of
/// @throws UsageError for another strategy or several bodies, another horizon or another step
std::vector<Answer> answers(const std::vector<Question>& questions,
                            const config::Scenario& scenario, const config::Scenario& planner);

}  // namespace c3rt::cli::gap
