#include "cli/tune/optimiser.hpp"

#include <cmath>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "cli/campaign/python.hpp"
#include "cli/program.hpp"

namespace c3rt::cli::tune {
namespace {

using nlohmann::ordered_json;

constexpr double kDraws = 120.0;  // on a busy machine [s]

std::vector<double> list(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

}  // namespace

int usual_population(int parameters) {
  return 4 + static_cast<int>(3.0 * std::log(static_cast<double>(parameters)));
}

std::vector<Eigen::VectorXd> next_candidates(const std::string& python, const Search& search,
                                             const std::vector<Generation>& history) {
  ordered_json generations = ordered_json::array();
  for (const Generation& generation : history) {
    ordered_json candidates = ordered_json::array();
    for (const Eigen::VectorXd& candidate : generation.candidates)
      candidates.push_back(list(candidate));
    generations.push_back({{"candidates", candidates}, {"ranks", generation.ranks}});
  }
  const ordered_json order{{"mean", list(search.mean)},
                           {"sigma", search.sigma},
                           {"seed", search.seed},
                           {"population", search.population},
                           {"generations", generations}};
  const ProgramEnd end = run_program({python, campaign::python_file("tune", "cma.py").string()},
                                     order.dump() + "\n", kDraws);
  const ordered_json answer = ordered_json::parse(end.output, nullptr, false);
  if (!end.ok() || !answer.is_object()) {
    throw std::runtime_error("CMA-ES: " + python + " " +
                             (end.ok() ? "gave no answer" : end.reason) +
                             (end.output.empty() ? "" : ": " + end.output));
  }
  std::vector<Eigen::VectorXd> candidates;
  for (const ordered_json& candidate : answer.at("candidates")) {
    const std::vector<double> values = candidate;
    candidates.emplace_back(
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  }
  return candidates;
}

}  // namespace c3rt::cli::tune
